//! The graphics device: a driver found with or without a window, what it is called, and what it can do.
//!
//! One tier: what WebGPU guarantees, a depth buffer with stencil, and timestamps where there are any. Lavapipe, Mesa's software
//! Vulkan, has all of it, so frames can be drawn where there is no graphics card.

use crate::targets::{IDS, LIGHT, MASKS, MEASURED};
use std::sync::{Arc, Mutex, PoisonError};

/// Why nothing can be drawn. `Display` is one line for the user.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RasterError {
    /// No driver.
    #[error(
        "no graphics driver was found; install one, for instance Mesa's software Vulkan: apt-get install mesa-vulkan-drivers ({0})"
    )]
    NoDriver(String),
    /// The driver refuses.
    #[error("{driver} cannot be used: {why}")]
    Refused {
        /// Its name.
        driver: String,
        /// Its reason.
        why: String,
    },
    /// A window that the driver cannot draw into.
    #[error("the window cannot be drawn into: {0}")]
    Window(String),
    /// The device went away while it drew.
    #[error("the graphics device was lost: {0}")]
    Lost(String),
    /// A frame that cannot be.
    #[error("a frame of {width}x{height} pixels cannot be drawn: each side must be 1 to {most}{}", if *grid > 1 { format!(" (with {grid}x{grid} samples a pixel)") } else { String::new() })]
    Size {
        /// Pixels.
        width: u32,
        /// Pixels.
        height: u32,
        /// Samples along each side of a pixel.
        grid: u32,
        /// Pixels, the driver's limit.
        most: u32,
    },
    /// More lamps than shaders can hold.
    #[error(
        "{lamps} lamps are lit whose direct light the rasteriser draws, more than {most}; give some of them `direct: photons`"
    )]
    Lamps {
        /// How many.
        lamps: usize,
        /// How many can be drawn.
        most: usize,
    },
    /// Too much for the device's memory.
    #[error("{what} needs {bytes} bytes, more than the {most} that {driver} can hold in one buffer")]
    TooLarge {
        /// What is too large.
        what: &'static str,
        /// Bytes.
        bytes: u64,
        /// Bytes.
        most: u64,
        /// The driver's name.
        driver: String,
    },
}

/// A graphics device and its queue.
#[derive(Debug)]
pub struct Device {
    /// wgpu's device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Driver and backend, for people: "llvmpipe (LLVM 15.0.6, 256 bits), Vulkan".
    pub name: String,
    /// Whether the processor draws, whose time others may need.
    pub on_processor: bool,
    lost: Arc<Mutex<Option<String>>>,
}

/// What drivers are looked for with, and where: all of them, or those of `WGPU_BACKEND`. Windows need their display.
pub(crate) fn instance(display: Option<Box<dyn wgpu::wgt::WgpuHasDisplayHandle>>) -> (wgpu::Instance, wgpu::Backends) {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::from_env().unwrap_or(descriptor.backends);
    descriptor.display = display;
    let backends = descriptor.backends;
    (wgpu::Instance::new(descriptor), backends)
}

impl Device {
    /// A device that draws without a window. `WGPU_BACKEND` (`vulkan`, `gl`) and `WGPU_ADAPTER_NAME` choose among several.
    pub fn headless() -> Result<Device, RasterError> {
        let (instance, backends) = instance(None);
        pollster::block_on(Device::find(&instance, backends, None)).map(|(device, _)| device)
    }

    /// The best device that can draw what we draw, and into `surface` if there is one.
    pub(crate) async fn find(
        instance: &wgpu::Instance,
        backends: wgpu::Backends,
        surface: Option<&wgpu::Surface<'_>>,
    ) -> Result<(Device, wgpu::Adapter), RasterError> {
        let wanted = std::env::var("WGPU_ADAPTER_NAME").ok().map(|name| name.to_lowercase());
        let mut adapters = instance.enumerate_adapters(backends).await;
        adapters.retain(|a| wanted.as_ref().is_none_or(|name| a.get_info().name.to_lowercase().contains(name)));
        let stencil = wgpu::Features::DEPTH32FLOAT_STENCIL8;
        let fault = |adapter: &wgpu::Adapter| {
            let draws_into = |format| {
                adapter.get_texture_format_features(format).allowed_usages.contains(wgpu::TextureUsages::RENDER_ATTACHMENT)
            };
            if !adapter.features().contains(stencil) {
                Some("it has no 32-bit depth buffer with a stencil")
            } else if ![IDS, MASKS, LIGHT, MEASURED].into_iter().all(draws_into) {
                Some("it cannot draw into textures of 32-bit numbers")
            } else if surface.is_some_and(|surface| !adapter.is_surface_supported(surface)) {
                Some("it cannot draw into this window")
            } else {
                None
            }
        };
        // What can draw, a graphics card before software, Vulkan before OpenGL; otherwise in the driver loader's order.
        let rank = |adapter: &wgpu::Adapter| {
            let info = adapter.get_info();
            let kind = match info.device_type {
                wgpu::DeviceType::DiscreteGpu => 0,
                wgpu::DeviceType::IntegratedGpu => 1,
                wgpu::DeviceType::VirtualGpu => 2,
                _ => 3,
            };
            (fault(adapter).is_some(), kind, u8::from(info.backend != wgpu::Backend::Vulkan))
        };
        adapters.sort_by_key(rank);
        let Some(adapter) = adapters.into_iter().next() else {
            let why = match wanted {
                Some(name) => format!("none of the drivers is called '{name}', as WGPU_ADAPTER_NAME asks"),
                None => format!("tried {backends:?}").to_lowercase(),
            };
            return Err(RasterError::NoDriver(why));
        };
        let info = adapter.get_info();
        let name = format!("{}, {:?}", info.name, info.backend);
        let on_processor = info.device_type == wgpu::DeviceType::Cpu;
        let refused = |why: String| RasterError::Refused { driver: name.clone(), why };
        if let Some(why) = fault(&adapter) {
            return Err(refused(why.into()));
        }
        let (device, queue) = adapter
            .request_device(&wgpu::DeviceDescriptor {
                label: Some("lightmend"),
                required_features: stencil | (adapter.features() & wgpu::Features::TIMESTAMP_QUERY),
                required_limits: adapter.limits(),
                ..Default::default()
            })
            .await
            .map_err(|e| refused(e.to_string()))?;
        let lost = Arc::new(Mutex::new(None));
        {
            let lost = lost.clone();
            device.set_device_lost_callback(move |reason, message| {
                let why = if message.is_empty() { format!("{reason:?}") } else { message };
                *lost.lock().unwrap_or_else(PoisonError::into_inner) = Some(why);
            });
        }
        {
            // What goes wrong between two looks is kept and told by the next one, in one line.
            let lost = lost.clone();
            device.on_uncaptured_error(Arc::new(move |error| {
                let line = error.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
                lost.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(line);
            }));
        }
        Ok((Device { device, queue, name, on_processor, lost }, adapter))
    }

    /// Whether the device still draws.
    pub fn check(&self) -> Result<(), RasterError> {
        match &*self.lost.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(why) => Err(RasterError::Lost(why.clone())),
            None => Ok(()),
        }
    }

    /// Waits for all that was submitted.
    pub fn wait(&self) -> Result<(), RasterError> {
        if let Err(e) = self.device.poll(wgpu::PollType::wait_indefinitely()) {
            self.check()?;
            return Err(RasterError::Lost(e.to_string()));
        }
        self.check()
    }

    /// Destroys the device, so that everything that uses it ends as [`RasterError::Lost`]: what a driver's crash or a card that is pulled
    /// out does, for those who want to try how they recover.
    pub fn lose(&self) {
        self.device.destroy();
    }

    /// The largest side of a frame, pixels.
    pub fn largest_side(&self) -> u32 {
        self.device.limits().max_texture_dimension_2d
    }

    /// A buffer of at least `bytes`.
    pub fn buffer(&self, what: &'static str, bytes: u64, usage: wgpu::BufferUsages) -> Result<wgpu::Buffer, RasterError> {
        let limits = self.device.limits();
        let storage = usage.contains(wgpu::BufferUsages::STORAGE);
        let most =
            if storage { limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) } else { limits.max_buffer_size };
        if bytes > most {
            return Err(RasterError::TooLarge { what, bytes, most, driver: self.name.clone() });
        }
        let size = bytes.max(256).next_multiple_of(256).min(most);
        let usage = usage | wgpu::BufferUsages::COPY_DST;
        Ok(self.device.create_buffer(&wgpu::BufferDescriptor { label: Some(what), size, usage, mapped_at_creation: false }))
    }
}
