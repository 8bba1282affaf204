//! What a picture of one size is drawn into, and the recording of a step of its frame.

use glam::Mat4;

use super::{
    g_buffer::{GBuffer, Layer, LayerGroups},
    lamps::LampPass,
    pace::{Step, Work},
    passes::{Dispatch, Groups, Pipelines},
    targets::Targets,
};
use crate::gpu::{ViewGeometry, mesh_buffers::MeshBuffers};

/// A picture's targets, and what binds them.
pub(super) struct Picture {
    pub(super) targets: Targets,
    pub(super) layers: LayerGroups,
    pub(super) groups: Groups,
    /// The camera of its last frame.
    pub(super) last_camera: Option<Mat4>,
    pub(super) next_page: usize,
}

/// Records a step; `is_first`: nothing stood still before.
pub(super) fn record(
    encoder: &mut wgpu::CommandEncoder,
    step: &Step,
    (lamps, g_buffer, pipelines): (&LampPass, &GBuffer, &Pipelines),
    (geometry, mesh, picture): (&ViewGeometry, &MeshBuffers, &Picture),
    is_first: bool,
) {
    let (targets, begins) = (&picture.targets, step.units.start == 0);
    match step.work {
        Work::Shadows => lamps.draw(encoder, step.units.clone()),
        Work::Surface(layer) => {
            if layer == Layer::First && begins {
                targets.keep_depth(encoder);
            }
            let drawn = (layer, step.units.clone(), begins);
            g_buffer.draw(encoder, (&geometry.scene, mesh), (targets, &picture.layers), drawn);
        }
        Work::Pixels(dispatch) => {
            if dispatch == Dispatch::Light && begins {
                // Else it would stay after it was turned off.
                encoder.clear_buffer(&targets.obscurance, 0, None);
                if is_first {
                    targets.forget_tail_around(encoder);
                }
            }
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            picture.groups.record(&mut pass, pipelines, dispatch, step.units.len() as u32);
        }
    }
}
