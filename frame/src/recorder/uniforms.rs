//! Small structs that one pass reads: written into chunks that are uploaded with each slice.

use crate::Gpu;

/// Bytes per slot: the default alignment of uniform offsets, and room for the largest params struct.
const SLOT: u64 = 512;
const SLOTS: u64 = 128;

/// A slot of the frame's uniform memory.
#[derive(Clone)]
pub struct Uniform {
    buffer: wgpu::Buffer,
    offset: u64,
    bytes: u64,
}

impl Uniform {
    /// For [`crate::Recorder::compute`]'s list.
    pub fn binding(&self) -> wgpu::BindingResource<'_> {
        wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &self.buffer,
            offset: self.offset,
            size: std::num::NonZeroU64::new(self.bytes),
        })
    }
}

struct Chunk {
    buffer: wgpu::Buffer,
    bytes: Vec<u8>,
    uploaded: usize,
}

#[derive(Default)]
pub(super) struct Uniforms(Vec<Chunk>);

impl Uniforms {
    pub(super) fn push(&mut self, gpu: &Gpu, value: &[u8]) -> Uniform {
        assert!(value.len() as u64 <= SLOT, "a uniform of {} bytes does not fit {SLOT}", value.len());
        if self.0.last().is_none_or(|c| c.bytes.len() as u64 >= SLOT * SLOTS) {
            let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("Uniforms::chunk"),
                size: SLOT * SLOTS,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            self.0.push(Chunk { buffer, bytes: Vec::new(), uploaded: 0 });
        }
        let last = self.0.len() - 1;
        let chunk = &mut self.0[last];
        let offset = chunk.bytes.len() as u64;
        chunk.bytes.extend_from_slice(value);
        chunk.bytes.resize((offset + SLOT) as usize, 0);
        let bytes = (value.len() as u64).next_multiple_of(16);
        Uniform { buffer: chunk.buffer.clone(), offset, bytes }
    }

    pub(super) fn upload(&mut self, gpu: &Gpu) {
        for chunk in self.0.iter_mut().filter(|c| c.uploaded < c.bytes.len()) {
            gpu.queue.write_buffer(&chunk.buffer, chunk.uploaded as u64, &chunk.bytes[chunk.uploaded..]);
            chunk.uploaded = chunk.bytes.len();
        }
        // Full and uploaded chunks are only kept alive by the bind groups that use them.
        self.0.retain(|c| (c.bytes.len() as u64) < SLOT * SLOTS);
    }
}
