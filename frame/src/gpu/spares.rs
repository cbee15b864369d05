//! What a frame needs only while it is recorded and read back: lent to it, taken back for the next one, so that a steady
//! frame allocates nothing.
//!
//! Buffers come in sizes that are powers of two, each usage apart. What is never asked for again stays: it is what the
//! largest frame so far needed, kilobytes.

use super::Gpu;
use super::memory::{Buffer, Room};
use crate::GpuError;
use std::sync::{Mutex, MutexGuard, PoisonError};

#[derive(Default)]
pub(super) struct Spares(Mutex<Shelf>);

#[derive(Default)]
struct Shelf {
    buffers: Vec<Buffer>,
    queries: Vec<wgpu::QuerySet>,
}

impl Spares {
    fn shelf(&self) -> MutexGuard<'_, Shelf> {
        // What lies there is whole, whoever died while holding the lock.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Gpu {
    /// A buffer of at least so many bytes, with whatever a frame before left in it. Goes back by [`Gpu::take_back`] once
    /// the device is done with it.
    pub(crate) fn lend(
        &self,
        label: &str,
        bytes: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<Buffer, GpuError> {
        let bytes = bytes.next_power_of_two().max(64);
        let mut shelf = self.spares.shelf();
        let found = shelf.buffers.iter().rposition(|b| b.usage() == usage && b.bytes() == bytes);
        match found {
            Some(at) => Ok(shelf.buffers.remove(at)),
            None => {
                drop(shelf);
                self.buffer(Room::Frame, label, bytes, usage)
            }
        }
    }

    /// The last one given is the first one lent again.
    pub(crate) fn take_back(&self, buffer: Buffer) {
        self.spares.shelf().buffers.push(buffer);
    }

    /// Timestamps, so many of them.
    pub(crate) fn lend_queries(&self, count: u32) -> wgpu::QuerySet {
        if let Some(queries) = self.spares.shelf().queries.pop() {
            return queries;
        }
        self.ledger.note();
        self.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("Timer::queries"),
            ty: wgpu::QueryType::Timestamp,
            count,
        })
    }

    /// All have the same number of timestamps.
    pub(crate) fn take_queries_back(&self, queries: wgpu::QuerySet) {
        self.spares.shelf().queries.push(queries);
    }
}
