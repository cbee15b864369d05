//! Buffers and textures that are counted while they live.

use std::ops::Deref;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What an allocation is for: the rows of `memory_bytes` in logs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Room {
    /// Meshes, materials, textures, sky.
    Scene,
    /// The voxel grid, and what building it takes.
    Voxels,
    /// G-buffers of both sizes.
    GBuffer,
    /// Light on its way: path state, sums, radiance images, the picture.
    Radiance,
    /// What a filter keeps from frame to frame.
    History,
    /// Triangle search structures.
    Bvh,
    /// Uniforms, queries, staging.
    Frame,
}

impl Room {
    const COUNT: usize = Self::Frame as usize + 1;
}

/// Bytes in one room.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Memory {
    /// Allocated now.
    pub live: u64,
    /// The most that was ever allocated at once.
    pub peak: u64,
}

#[derive(Default)]
pub(super) struct Ledger {
    rooms: Mutex<[Memory; Room::COUNT]>,
    made: AtomicU64,
}

impl Ledger {
    fn rooms(&self) -> MutexGuard<'_, [Memory; Room::COUNT]> {
        // Plain sums stay true even if a thread died while holding the lock.
        self.rooms.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// One more thing was made on the device.
    pub(super) fn note(&self) {
        self.made.fetch_add(1, Ordering::Relaxed);
    }

    pub(super) fn made(&self) -> u64 {
        self.made.load(Ordering::Relaxed)
    }

    pub(super) fn memory(&self, room: Room) -> Memory {
        self.rooms()[room as usize]
    }

    pub(super) fn live(&self) -> u64 {
        self.rooms().iter().map(|m| m.live).sum()
    }

    pub(super) fn open(self: &Arc<Self>, room: Room, bytes: u64) -> Entry {
        self.note();
        let memory = &mut self.rooms()[room as usize];
        memory.live += bytes;
        memory.peak = memory.peak.max(memory.live);
        Entry { ledger: self.clone(), room, bytes }
    }
}

/// One line of the ledger, struck out when dropped.
pub(super) struct Entry {
    ledger: Arc<Ledger>,
    room: Room,
    bytes: u64,
}

impl Drop for Entry {
    fn drop(&mut self) {
        self.ledger.rooms()[self.room as usize].live -= self.bytes;
    }
}

/// A wgpu buffer whose bytes are counted.
#[derive(Clone)]
pub struct Buffer {
    raw: wgpu::Buffer,
    label: Arc<str>,
    bytes: u64,
    _entry: Arc<Entry>,
}

impl Buffer {
    pub(super) fn new(raw: wgpu::Buffer, label: &str, bytes: u64, entry: Entry) -> Self {
        Self { raw, label: label.into(), bytes, _entry: Arc::new(entry) }
    }

    /// Allocated size.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// `Type::field`.
    pub fn label(&self) -> &str {
        &self.label
    }
}

impl Deref for Buffer {
    type Target = wgpu::Buffer;

    fn deref(&self) -> &wgpu::Buffer {
        &self.raw
    }
}

/// A wgpu texture with its one view over everything, whose bytes are counted.
#[derive(Clone)]
pub struct Texture {
    raw: wgpu::Texture,
    view: wgpu::TextureView,
    label: Arc<str>,
    entry: Arc<Entry>,
}

impl Texture {
    pub(super) fn new(raw: wgpu::Texture, label: &str, array: bool, entry: Entry) -> Self {
        let dimension =
            if array { wgpu::TextureViewDimension::D2Array } else { wgpu::TextureViewDimension::D2 };
        let view = raw
            .create_view(&wgpu::TextureViewDescriptor { dimension: Some(dimension), ..Default::default() });
        Self { raw, view, label: label.into(), entry: Arc::new(entry) }
    }

    /// All mips and layers: `D2Array` with more than one layer, else `D2`.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// All mips and layers as an array, also of one layer.
    #[must_use]
    pub fn as_array(self) -> Self {
        let view = self.raw.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        Self { view, ..self }
    }

    /// Allocated size.
    pub fn bytes(&self) -> u64 {
        self.entry.bytes
    }

    /// `Type::field`.
    pub fn label(&self) -> &str {
        &self.label
    }
}

impl Deref for Texture {
    type Target = wgpu::Texture;

    fn deref(&self) -> &wgpu::Texture {
        &self.raw
    }
}
