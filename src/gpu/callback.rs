//! Views as egui shapes.
//!
//! A view is drawn into its own picture before egui's pass and copied during it: egui's pass has no depth attachment
//! in tests, and may have other numbers of samples.

use eframe::egui_wgpu::{CallbackResources, CallbackTrait, RenderState, ScreenDescriptor};
use egui::{PaintCallback, PaintCallbackInfo, Rect};

use super::{
    ViewFrame, Viewer,
    map_picture::{MapPicture, MapPictureFrame},
};

/// Makes the window able to show views: call once, when the window is made, with `CreationContext::wgpu_render_state`.
pub fn install(render_state: &RenderState) {
    let viewer = Viewer::new(&render_state.device, render_state.target_format);
    render_state.renderer.write().callback_resources.insert(viewer);
}

/// True for a driver that draws on the processor's own cores.
pub fn is_software(render_state: &RenderState) -> bool {
    render_state.adapter.get_info().device_type == wgpu::DeviceType::Cpu
}

/// The shape that shows a frame in `rect` (points): `ui.painter().add(paint_callback(rect, ppp, frame))`. Sets the
/// frame's size in pixels. Nothing is shown where [`install`] was not called.
pub fn paint_callback(rect: Rect, pixels_per_point: f32, mut frame: ViewFrame) -> PaintCallback {
    let pixel = |points: f32| (points * pixels_per_point).round() as i32;
    let origin = [pixel(rect.left()), pixel(rect.top())];
    frame.size = [pixel(rect.right()) - origin[0], pixel(rect.bottom()) - origin[1]].map(|size| size.max(0) as u32);
    eframe::egui_wgpu::Callback::new_paint_callback(rect, Shown { frame, origin })
}

/// A frame on its way to the screen.
struct Shown {
    frame: ViewFrame,
    /// The top left pixel in the window.
    origin: [i32; 2],
}

impl CallbackTrait for Shown {
    fn prepare(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        _screen: &ScreenDescriptor,
        encoder: &mut wgpu::CommandEncoder,
        resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        if let Some(viewer) = resources.get_mut::<Viewer>() {
            viewer.draw(device, queue, encoder, &self.frame);
            viewer.place(queue, self.frame.view, self.origin, self.frame.size);
        }
        Vec::new()
    }

    fn paint(&self, _info: PaintCallbackInfo, pass: &mut wgpu::RenderPass<'static>, resources: &CallbackResources) {
        if let Some(viewer) = resources.get::<Viewer>() {
            viewer.show(pass, self.frame.view);
        }
    }
}

/// The shape that shows a page of a lightmap or a batch's hemicubes in `rect` (points); sets its place and size. At most
/// one a frame. Nothing is shown where [`install`] was not called.
pub fn picture_callback(rect: Rect, pixels_per_point: f32, mut frame: MapPictureFrame) -> PaintCallback {
    let pixel = |points: f32| (points * pixels_per_point).round() as i32;
    frame.origin = [pixel(rect.left()), pixel(rect.top())];
    let far = [pixel(rect.right()), pixel(rect.bottom())];
    frame.size = std::array::from_fn(|axis| (far[axis] - frame.origin[axis]).max(0) as u32);
    eframe::egui_wgpu::Callback::new_paint_callback(rect, Picture(frame))
}

struct Picture(MapPictureFrame);

impl CallbackTrait for Picture {
    fn prepare(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        _screen: &ScreenDescriptor,
        _encoder: &mut wgpu::CommandEncoder,
        resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        let format = resources.get::<Viewer>().map(Viewer::target_format);
        if let Some(format) = format {
            let picture = resources.entry::<MapPicture>().or_insert_with(|| MapPicture::new(device, format));
            picture.prepare(device, queue, &self.0);
        }
        Vec::new()
    }

    fn paint(&self, _info: PaintCallbackInfo, pass: &mut wgpu::RenderPass<'static>, resources: &CallbackResources) {
        if let Some(picture) = resources.get::<MapPicture>() {
            picture.record(pass);
        }
    }
}
