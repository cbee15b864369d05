//! Bind groups of a frame that comes again: made once, found by what they bind.
//!
//! A group that [`KEPT`] frames had no use for is dropped, and with it goes the last hold on what it binds. So only frames
//! that come again keep theirs ([`super::Recorder::of_frame`]): a build would hold on to its scratch memory.

use super::Gpu;
use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// One resource, as it is told from others.
#[derive(Clone, PartialEq, Eq, Hash)]
enum Resource {
    Buffer(wgpu::Buffer, u64, Option<std::num::NonZeroU64>),
    View(wgpu::TextureView),
    Sampler(wgpu::Sampler),
}

impl Resource {
    /// None for the kinds that no kernel here binds.
    fn of(resource: &wgpu::BindingResource<'_>) -> Option<Self> {
        match resource {
            wgpu::BindingResource::Buffer(b) => Some(Self::Buffer(b.buffer.clone(), b.offset, b.size)),
            wgpu::BindingResource::TextureView(view) => Some(Self::View((*view).clone())),
            wgpu::BindingResource::Sampler(sampler) => Some(Self::Sampler((*sampler).clone())),
            _ => None,
        }
    }
}

/// Frames that a group outlives its last use by: those of a split screen take turns.
const KEPT: u64 = 4;

type Key = (wgpu::BindGroupLayout, Vec<Resource>);

struct Group {
    group: wgpu::BindGroup,
    /// The last frame that bound it.
    used: u64,
}

/// Kept on the [`Gpu`] from frame to frame.
#[derive(Default)]
pub(crate) struct BindGroups(Mutex<Kept>);

#[derive(Default)]
struct Kept {
    frame: u64,
    groups: HashMap<Key, Group>,
}

impl BindGroups {
    fn kept(&self) -> MutexGuard<'_, Kept> {
        // Groups are whole, whoever died while holding the lock.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The group of these entries, made where it is not there.
    pub(crate) fn get(
        &self,
        gpu: &Gpu,
        name: &str,
        layout: &wgpu::BindGroupLayout,
        entries: &[wgpu::BindGroupEntry<'_>],
    ) -> wgpu::BindGroup {
        let make = || {
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(name), layout, entries })
        };
        let Some(resources) = entries.iter().map(|e| Resource::of(&e.resource)).collect() else {
            return make();
        };
        let mut kept = self.kept();
        let frame = kept.frame;
        let found = kept.groups.entry((layout.clone(), resources)).or_insert_with(|| {
            gpu.note_allocation();
            Group { group: make(), used: frame }
        });
        found.used = frame;
        found.group.clone()
    }

    /// A frame is over: forgets what has not been used for long.
    pub(super) fn frame_is_over(&self) {
        let mut kept = self.kept();
        kept.frame += 1;
        let frame = kept.frame;
        kept.groups.retain(|_, group| frame - group.used <= KEPT);
    }
}
