//! What a device says when it fails or is lost, kept until somebody asks.

use std::sync::{Arc, Mutex, PoisonError};

/// Troubles of one device.
#[derive(Clone, Default)]
pub struct Troubles(Arc<Mutex<Vec<Trouble>>>);

/// What happened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// The device is gone, with the driver's words: nothing can be drawn with it any more.
    Lost(String),
    /// Something could not be done, for want of memory for example; one line.
    Failed(String),
}

impl Troubles {
    /// Listens to a device from now on, instead of panicking at its first error. `wake` is called when there is news.
    pub fn watch(device: &wgpu::Device, wake: impl Fn() + Clone + Send + Sync + 'static) -> Self {
        let troubles = Self::default();
        let (of_loss, wake_of_loss) = (troubles.clone(), wake.clone());
        device.set_device_lost_callback(move |reason, message| {
            of_loss.add(Trouble::Lost(format!("{reason:?}: {message}")));
            wake_of_loss();
        });
        let of_errors = troubles.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            of_errors.add(Trouble::Failed(error.to_string().replace('\n', " ")));
            wake();
        }));
        troubles
    }

    /// What happened since the last call, each thing once.
    pub fn take(&self) -> Vec<Trouble> {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn add(&self, trouble: Trouble) {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if !known.contains(&trouble) {
            known.push(trouble);
        }
    }
}
