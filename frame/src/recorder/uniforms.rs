//! Small structs that one pass reads: written into chunks that are uploaded with each slice.

use crate::{Buffer, Gpu, GpuError};

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
    /// Where there is no memory for one. The frame has failed; what it goes on to record is never submitted.
    pub(super) fn none(gpu: &Gpu) -> Self {
        let descriptor = wgpu::BufferDescriptor {
            label: Some("Uniform::none"),
            size: SLOT,
            usage: wgpu::BufferUsages::UNIFORM,
            mapped_at_creation: false,
        };
        Self { buffer: gpu.device.create_buffer(&descriptor), offset: 0, bytes: SLOT }
    }

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
    buffer: Buffer,
    bytes: Vec<u8>,
    uploaded: usize,
}

/// Chunks in the order they were begun; all but the last are full.
#[derive(Default)]
pub(super) struct Uniforms(Vec<Chunk>);

impl Uniforms {
    /// # Errors
    /// No memory for another chunk.
    pub(super) fn push(&mut self, gpu: &Gpu, value: &[u8]) -> Result<Uniform, GpuError> {
        assert!(value.len() as u64 <= SLOT, "a uniform of {} bytes does not fit {SLOT}", value.len());
        let is_full = |c: &Chunk| c.bytes.len() as u64 >= SLOT * SLOTS;
        let begun = self.0.pop_if(|c| !is_full(c));
        let mut chunk = match begun {
            Some(chunk) => chunk,
            None => {
                let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
                let buffer = gpu.lend("Uniforms::chunk", SLOT * SLOTS, usage)?;
                Chunk { buffer, bytes: Vec::new(), uploaded: 0 }
            }
        };
        let offset = chunk.bytes.len() as u64;
        chunk.bytes.extend_from_slice(value);
        chunk.bytes.resize((offset + SLOT) as usize, 0);
        let bytes = (value.len() as u64).next_multiple_of(16);
        let uniform = Uniform { buffer: (*chunk.buffer).clone(), offset, bytes };
        self.0.push(chunk);
        Ok(uniform)
    }

    pub(super) fn upload(&mut self, gpu: &Gpu) {
        for chunk in self.0.iter_mut().filter(|c| c.uploaded < c.bytes.len()) {
            gpu.queue.write_buffer(&chunk.buffer, chunk.uploaded as u64, &chunk.bytes[chunk.uploaded..]);
            chunk.uploaded = chunk.bytes.len();
        }
    }

    /// The device is done with all of them.
    pub(super) fn give_back(&mut self, gpu: &Gpu) {
        // The first is lent first again: what a steady frame binds is where it was.
        for chunk in self.0.drain(..).rev() {
            gpu.take_back(chunk.buffer);
        }
    }
}
