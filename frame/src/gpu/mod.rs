//! The adapter, the device, and everything allocated on it.
//!
//! Only wgpu's default limits are asked for, so that what runs here runs on every adapter that meets them; what an
//! adapter lacks is listed in one error. Each allocation names the [`Room`] it belongs to, and the bytes reported in
//! logs are the bytes that were allocated.

mod canary;
mod memory;
mod spares;

pub use memory::{Buffer, Memory, Room, Texture};

use crate::kernel::Edits;
use crate::recorder::BindGroups;
use memory::Ledger;
use spares::Spares;
use std::sync::{Arc, OnceLock};

/// Environment variable that names the adapter when the command line does not.
pub const ADAPTER_VARIABLE: &str = "GRIDLIGHT_ADAPTER";

/// What can go wrong between here and the driver.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// No adapter at all, or none whose name contains the one asked for.
    #[error(
        "no graphics adapter{wanted}; found: {found}. A software one is Mesa's (Debian: mesa-vulkan-drivers)"
    )]
    NoAdapter {
        /// ` named "x"`, or empty.
        wanted: String,
        /// Comma list of what there is, or "none".
        found: String,
    },
    /// The adapter lacks something of wgpu's default limits.
    #[error("adapter \"{adapter}\" lacks: {missing}")]
    Missing {
        /// The adapter's name.
        adapter: String,
        /// Everything missing, each with the value needed and the value there.
        missing: String,
    },
    /// The driver refused a device.
    #[error("adapter \"{adapter}\" gave no device: {message}")]
    NoDevice {
        /// The adapter's name.
        adapter: String,
        /// wgpu's words.
        message: String,
    },
    /// A buffer or texture larger than the device allows.
    #[error("{what} needs {needed} {unit}, the adapter allows {allowed}; {advice}")]
    TooLarge {
        /// Label of the resource.
        what: String,
        /// What it needs.
        needed: u64,
        /// What the limit is.
        allowed: u64,
        /// "bytes" or "pixels".
        unit: &'static str,
        /// What the user can do about it.
        advice: &'static str,
    },
    /// The device ran out of memory.
    #[error("out of GPU memory for {what} ({bytes} bytes; {live} bytes live already)")]
    OutOfMemory {
        /// Label of the resource.
        what: String,
        /// Its size.
        bytes: u64,
        /// What was allocated before.
        live: u64,
    },
    /// A shader is wrong, or the Rust side describes it wrongly.
    #[error(transparent)]
    Kernel(#[from] crate::KernelError),
    /// A library that a stage loads while the program runs is of no use.
    #[error("{message}")]
    Library {
        /// Which, why, and what can be done.
        message: String,
    },
    /// Reading back failed; the device was most likely lost.
    #[error("reading {what} back failed: {message}")]
    ReadBack {
        /// Label of the resource.
        what: String,
        /// wgpu's words.
        message: String,
    },
}

/// A device and its queue, shared by every stage. A clone is the same device, and its bytes are counted with it.
#[derive(Clone)]
pub struct Gpu {
    /// wgpu's device; resources are made through [`Gpu::buffer`] and [`Gpu::texture`] so that they are counted.
    pub device: wgpu::Device,
    /// wgpu's queue.
    pub queue: wgpu::Queue,
    /// Name, driver and kind, for logs.
    pub info: wgpu::AdapterInfo,
    /// Nanoseconds per timestamp tick; none where the adapter has no timestamps.
    pub timestamp_period: Option<f32>,
    ledger: Arc<Ledger>,
    spares: Arc<Spares>,
    pub(crate) bind_groups: Arc<BindGroups>,
    pub(crate) edits: Arc<Edits>,
    loop_cap: OnceLock<Option<u32>>,
}

impl Gpu {
    /// Opens the adapter whose name contains `name` (any case), else the one named by [`ADAPTER_VARIABLE`], else the
    /// fastest kind there is.
    ///
    /// # Errors
    /// No such adapter, one that lacks wgpu's default limits, or a driver that gives no device.
    pub fn new(name: Option<&str>) -> Result<Self, GpuError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
        let from_environment = std::env::var(ADAPTER_VARIABLE).ok().filter(|s| !s.is_empty());
        let wanted = name.map(str::to_owned).or(from_environment);
        Self::from_adapter(&choose(adapters, wanted.as_deref())?)
    }

    /// Opens a device on an adapter that was found elsewhere (the viewer's, which must fit its surface).
    ///
    /// # Errors
    /// The adapter lacks wgpu's default limits, or the driver gives no device.
    pub fn from_adapter(adapter: &wgpu::Adapter) -> Result<Self, GpuError> {
        let info = adapter.get_info();
        let limits = wgpu::Limits::default();
        let mut missing = Vec::new();
        limits.check_limits_with_fail_fn(&adapter.limits(), false, |limit, needed, there| {
            missing.push(format!("{limit} {needed} (has {there})"));
        });
        let downlevel = adapter.get_downlevel_capabilities();
        if !downlevel.flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS) {
            missing.push("compute shaders".into());
        }
        if !downlevel.flags.contains(wgpu::DownlevelFlags::FRAGMENT_WRITABLE_STORAGE) {
            missing.push("storage writes from fragments".into());
        }
        if !missing.is_empty() {
            return Err(GpuError::Missing { adapter: info.name, missing: missing.join(", ") });
        }
        let timestamps = adapter.features() & wgpu::Features::TIMESTAMP_QUERY;
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("gridlight"),
            required_features: timestamps,
            required_limits: limits,
            ..Default::default()
        }))
        .map_err(|e| GpuError::NoDevice { adapter: info.name.clone(), message: e.to_string() })?;
        let timestamp_period = (!timestamps.is_empty()).then(|| queue.get_timestamp_period());
        Ok(Self {
            device,
            queue,
            info,
            timestamp_period,
            ledger: Arc::default(),
            spares: Arc::default(),
            bind_groups: Arc::default(),
            edits: Arc::default(),
            loop_cap: OnceLock::new(),
        })
    }

    /// Whether a CPU does the work.
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// The number of loop iterations after which this driver silently ends all loops of an invocation group, or none
    /// up to the 2^17 that were tried. Measured once, by [`canary`]'s kernel.
    pub fn loop_cap(&self) -> Option<u32> {
        *self.loop_cap.get_or_init(|| canary::measure(self))
    }

    /// Bytes allocated now and at most, in one room.
    pub fn memory(&self, room: Room) -> Memory {
        self.ledger.memory(room)
    }

    /// Buffers, textures, query sets and the bind groups of frames that were made so far. A steady frame makes none.
    pub fn allocations(&self) -> u64 {
        self.ledger.made()
    }

    pub(crate) fn note_allocation(&self) {
        self.ledger.note();
    }

    /// A buffer; contents are zero.
    ///
    /// # Errors
    /// Larger than the device allows, or out of memory.
    pub fn buffer(
        &self,
        room: Room,
        label: &str,
        bytes: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<Buffer, GpuError> {
        // wgpu wants whole words, and a binding of no bytes is refused: an empty list still gets one word.
        let bytes = bytes.max(4).next_multiple_of(4);
        let limits = self.device.limits();
        let allowed = match usage.contains(wgpu::BufferUsages::STORAGE) {
            true => limits.max_storage_buffer_binding_size.min(limits.max_buffer_size),
            false => limits.max_buffer_size,
        };
        if bytes > allowed {
            let advice = "lower --grid, the picture size or the scene's size";
            return Err(GpuError::TooLarge {
                what: label.into(),
                needed: bytes,
                allowed,
                unit: "bytes",
                advice,
            });
        }
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let raw = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes,
            usage,
            mapped_at_creation: false,
        });
        if pollster::block_on(scope.pop()).is_some() {
            return Err(GpuError::OutOfMemory { what: label.into(), bytes, live: self.ledger.live() });
        }
        Ok(Buffer::new(raw, label, bytes, self.ledger.open(room, bytes)))
    }

    /// A storage buffer holding `data`, that can also be copied from and to.
    ///
    /// # Errors
    /// Larger than the device allows, or out of memory.
    pub fn storage<T: bytemuck::NoUninit>(
        &self,
        room: Room,
        label: &str,
        data: &[T],
    ) -> Result<Buffer, GpuError> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let buffer = self.buffer(room, label, bytes.len() as u64, usage)?;
        self.queue.write_buffer(&buffer, 0, bytes);
        Ok(buffer)
    }

    /// A 2D texture with one mip level, or an array of them (`size` is width, height, layers).
    ///
    /// # Errors
    /// Larger than the device allows, or out of memory.
    pub fn texture(
        &self,
        room: Room,
        label: &str,
        [width, height, layers]: [u32; 3],
        mip_level_count: u32,
        format: wgpu::TextureFormat,
        usage: wgpu::TextureUsages,
    ) -> Result<Texture, GpuError> {
        let limits = self.device.limits();
        let (longest, allowed) = (width.max(height), limits.max_texture_dimension_2d);
        if longest > allowed || layers > limits.max_texture_array_layers {
            let (needed, allowed) = if longest > allowed {
                (longest, allowed)
            } else {
                (layers, limits.max_texture_array_layers)
            };
            return Err(GpuError::TooLarge {
                what: label.into(),
                needed: needed.into(),
                allowed: allowed.into(),
                unit: if longest > limits.max_texture_dimension_2d { "pixels" } else { "layers" },
                advice: "lower the picture size",
            });
        }
        let size = wgpu::Extent3d {
            width: width.max(1),
            height: height.max(1),
            depth_or_array_layers: layers.max(1),
        };
        let descriptor = wgpu::TextureDescriptor {
            label: Some(label),
            size,
            mip_level_count,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        };
        let texel = u64::from(format.block_copy_size(None).unwrap_or(4));
        let bytes = (0..mip_level_count)
            .map(|m| u64::from((size.width >> m).max(1)) * u64::from((size.height >> m).max(1)))
            .sum::<u64>()
            * u64::from(size.depth_or_array_layers)
            * texel;
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let raw = self.device.create_texture(&descriptor);
        if pollster::block_on(scope.pop()).is_some() {
            return Err(GpuError::OutOfMemory { what: label.into(), bytes, live: self.ledger.live() });
        }
        Ok(Texture::new(raw, label, layers > 1, self.ledger.open(room, bytes)))
    }

    /// Copies a whole buffer back, waiting for everything submitted before.
    ///
    /// # Errors
    /// The device was lost, or has no memory for the copy.
    pub fn read_buffer<T: bytemuck::Pod>(&self, buffer: &Buffer) -> Result<Vec<T>, GpuError> {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let staging = self.buffer(Room::Frame, "Gpu::read_buffer", buffer.bytes(), usage)?;
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.bytes());
        self.queue.submit([encoder.finish()]);
        Ok(bytemuck::pod_collect_to_vec(&self.map(&staging, buffer.label())?))
    }

    /// Copies mip 0 of one layer back, rows tightly packed, waiting for everything submitted before.
    ///
    /// # Errors
    /// The device was lost, or has no memory for the copy.
    pub fn read_texture<T: bytemuck::Pod>(&self, texture: &Texture) -> Result<Vec<T>, GpuError> {
        let texel = texture.format().block_copy_size(None).unwrap_or(4);
        let (width, height) = (texture.width(), texture.height());
        let row = width * texel;
        let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let bytes = u64::from(padded) * u64::from(height);
        let staging = self.buffer(Room::Frame, "Gpu::read_texture", bytes, usage)?;
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &staging,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(padded),
                    rows_per_image: Some(height),
                },
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        self.queue.submit([encoder.finish()]);
        let mapped = self.map(&staging, texture.label())?;
        let tight: Vec<u8> =
            mapped.chunks_exact(padded as usize).flat_map(|line| &line[..row as usize]).copied().collect();
        Ok(bytemuck::pod_collect_to_vec(&tight))
    }

    /// Maps a `MAP_READ` buffer and copies it out.
    pub(crate) fn map(&self, staging: &Buffer, what: &str) -> Result<Vec<u8>, GpuError> {
        let lost = |message: String| GpuError::ReadBack { what: what.into(), message };
        let (sender, receiver) = std::sync::mpsc::channel();
        staging.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver waits below; were it gone, there would be nobody to tell.
            let _ = sender.send(result);
        });
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| lost(e.to_string()))?;
        receiver.recv().map_err(|e| lost(e.to_string()))?.map_err(|e| lost(e.to_string()))?;
        let view = staging.get_mapped_range(..).map_err(|e| lost(e.to_string()))?;
        let bytes = view.to_vec();
        drop(view);
        staging.unmap();
        Ok(bytes)
    }
}

/// The named adapter, else the fastest kind: discrete, integrated, virtual, software.
fn choose(adapters: Vec<wgpu::Adapter>, wanted: Option<&str>) -> Result<wgpu::Adapter, GpuError> {
    let names: Vec<_> = adapters.iter().map(|a| a.get_info().name).collect();
    let rank = |kind| match kind {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    };
    adapters
        .into_iter()
        .filter(|a| wanted.is_none_or(|w| a.get_info().name.to_lowercase().contains(&w.to_lowercase())))
        .min_by_key(|a| rank(a.get_info().device_type))
        .ok_or_else(|| GpuError::NoAdapter {
            wanted: wanted.map(|w| format!(" named \"{w}\"")).unwrap_or_default(),
            found: if names.is_empty() { "none".into() } else { names.join(", ") },
        })
}
