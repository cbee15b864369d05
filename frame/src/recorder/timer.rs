//! Timestamps at pass boundaries, in sets that are resolved with each slice and read at the end.
//!
//! Mesa's software driver runs a dispatch when it meets it, but keeps timestamps back until the next barrier: the
//! one at a pass's beginning is taken after the pass's work. Its passes never overlap, so there a pass lasts from the end
//! of the one before it, and an empty pass marks where a slice begins.

use super::PassLog;
use crate::{Buffer, Gpu, GpuError};

/// Passes one query set can time: enough for a slice, small enough for every adapter (the limit is 4,096 queries).
const CAPACITY: u32 = 64;

/// Name of the empty pass that marks the beginning of a slice.
const MARK: &str = "";

/// Two timestamps around one pass.
pub(super) struct Span {
    queries: wgpu::QuerySet,
    index: u32,
}

impl Span {
    pub(super) fn queries(&self) -> &wgpu::QuerySet {
        &self.queries
    }

    pub(super) fn begin(&self) -> u32 {
        2 * self.index
    }

    pub(super) fn end(&self) -> u32 {
        2 * self.index + 1
    }

    pub(super) fn of_compute(&self) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(self.begin()),
            end_of_pass_write_index: Some(self.end()),
        }
    }
}

/// Times a frame's passes.
pub(super) struct Timer {
    queries: Option<wgpu::QuerySet>,
    late_begin: bool,
    /// Passes since the last resolve.
    names: Vec<String>,
    /// Resolved, not yet read.
    resolved: Vec<(Buffer, Vec<String>)>,
    /// Where timestamps go before they can be mapped.
    between: Vec<Buffer>,
}

impl Timer {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let queries = gpu.timestamp_period.map(|_| gpu.lend_queries(2 * CAPACITY));
        let late_begin = queries.is_some() && gpu.info.device_type == wgpu::DeviceType::Cpu;
        Self { queries, late_begin, names: Vec::new(), resolved: Vec::new(), between: Vec::new() }
    }

    /// The span of an empty pass, where one has to mark the beginning of a slice.
    pub(super) fn mark(&mut self) -> Option<Span> {
        if self.late_begin && self.names.is_empty() { self.begin(MARK) } else { None }
    }

    pub(super) fn begin(&mut self, pass: &str) -> Option<Span> {
        let index = self.names.len() as u32;
        self.names.push(pass.into());
        self.queries.clone().map(|queries| Span { queries, index })
    }

    pub(super) fn is_full(&self) -> bool {
        self.names.len() as u32 == CAPACITY
    }

    /// Copies the slice's timestamps to where they can be mapped.
    pub(super) fn resolve(&mut self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder) -> Result<(), GpuError> {
        let names = std::mem::take(&mut self.names);
        if names.is_empty() {
            return Ok(());
        }
        let bytes = 16 * names.len() as u64;
        let staging_usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let staging = gpu.lend("Timer::staging", bytes, staging_usage)?;
        if let Some(queries) = &self.queries {
            let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
            let resolved = gpu.lend("Timer::resolved", bytes, usage)?;
            encoder.resolve_query_set(queries, 0..2 * names.len() as u32, &resolved, 0);
            encoder.copy_buffer_to_buffer(&resolved, 0, &staging, 0, bytes);
            self.between.push(resolved);
        }
        self.resolved.push((staging, names));
        Ok(())
    }

    /// Sums by name, in order of first run. Waits for the work.
    pub(super) fn read(self, gpu: &Gpu) -> Result<Vec<PassLog>, GpuError> {
        let mut passes: Vec<PassLog> = Vec::new();
        for (staging, names) in self.resolved {
            let ticks: Vec<u64> = match gpu.timestamp_period {
                Some(_) => bytemuck::pod_collect_to_vec(&gpu.map(&staging, "Timer::staging")?),
                None => vec![0; 2 * names.len()],
            };
            let mut end_before = 0;
            for (name, pair) in names.into_iter().zip(ticks.chunks_exact(2)) {
                let begin = if self.late_begin { end_before } else { pair[0] };
                end_before = pair[1];
                if name == MARK {
                    continue;
                }
                let ms = gpu
                    .timestamp_period
                    .map(|ns| pair[1].saturating_sub(begin) as f64 * f64::from(ns) * 1e-6);
                match passes.iter_mut().find(|p| p.name == name) {
                    Some(p) => {
                        p.gpu_ms = p.gpu_ms.zip(ms).map(|(a, b)| a + b);
                        p.runs += 1;
                    }
                    None => passes.push(PassLog { name, gpu_ms: ms, runs: 1 }),
                }
            }
            gpu.take_back(staging);
        }
        for buffer in self.between {
            gpu.take_back(buffer);
        }
        if let Some(queries) = self.queries {
            gpu.take_queries_back(queries);
        }
        Ok(passes)
    }
}
