//! Records passes, times them at their boundaries, and knows what they wrote.
//!
//! A stage names a pass by its path (`denoise/five_phase/phase2/horizontal`) and does nothing else for timing, debug
//! views or counts: whoever records collects them into the [`FrameLog`]. Work is submitted in slices, at most two of
//! them in flight, so that a long render neither floods the driver nor starves a window.

mod bound;
mod log;
mod timer;
mod uniforms;

pub(crate) use bound::BindGroups;
pub use log::{FrameLog, PassLog};
pub use uniforms::Uniform;

use crate::kernel::Layout;
use crate::{Buffer, Gpu, GpuError, Kernel, RasterKernel, Texture};
use timer::{Span, Timer};
use uniforms::Uniforms;

/// Passes per submit. A pass of the software adapter takes a few milliseconds, so a slice stays near 30 ms; the
/// heavy ones (a traced sample) ask for a slice of their own through [`Recorder::flush`].
const PASSES_PER_SUBMIT: usize = 8;

/// What a raster pass draws into.
pub struct RasterTargets<'a> {
    /// Colour views in the kernel's order, each with the value it is cleared to (none keeps what is there).
    pub colors: &'a [(&'a wgpu::TextureView, Option<wgpu::Color>)],
    /// Depth view and the value it is cleared to (none keeps what is there).
    pub depth: Option<(&'a wgpu::TextureView, Option<f32>)>,
}

/// One frame being recorded.
pub struct Recorder<'g> {
    gpu: &'g Gpu,
    encoder: wgpu::CommandEncoder,
    passes_in_slice: usize,
    uniforms: Uniforms,
    timer: Timer,
    outputs: Vec<(String, Texture)>,
    counters: Vec<(String, Buffer, u64)>,
    in_flight: Option<wgpu::SubmissionIndex>,
    progress: Option<Box<dyn FnMut(f32) + 'g>>,
    failed: Option<GpuError>,
    /// Whether bind groups are kept for the next frame.
    comes_again: bool,
}

impl<'g> Recorder<'g> {
    /// Begins a frame of many: what its passes bind is kept for the next one, which will bind most of it again.
    pub fn of_frame(gpu: &'g Gpu) -> Self {
        Self { comes_again: true, ..Self::new(gpu) }
    }

    /// Begins what is done once, or a frame alone.
    pub fn new(gpu: &'g Gpu) -> Self {
        Self {
            gpu,
            encoder: gpu.device.create_command_encoder(&Default::default()),
            passes_in_slice: 0,
            uniforms: Uniforms::default(),
            timer: Timer::new(gpu),
            outputs: Vec::new(),
            counters: Vec::new(),
            in_flight: None,
            progress: None,
            failed: None,
            comes_again: false,
        }
    }

    /// The device this frame runs on.
    pub fn gpu(&self) -> &'g Gpu {
        self.gpu
    }

    /// Who is told how far a long stage has come, 0..1.
    pub fn on_progress(&mut self, progress: impl FnMut(f32) + 'g) {
        self.progress = Some(Box::new(progress));
    }

    /// A long stage says how far it has come, 0..1.
    pub fn progress(&mut self, done: f32) {
        if let Some(progress) = &mut self.progress {
            progress(done);
        }
    }

    /// A uniform that lives until the frame is done.
    pub fn uniform<T: bytemuck::NoUninit>(&mut self, value: &T) -> Uniform {
        let bytes = bytemuck::bytes_of(value);
        self.uniforms.push(self.gpu, bytes).unwrap_or_else(|error| {
            self.fail(error);
            Uniform::none(self.gpu)
        })
    }

    /// Fills a buffer with zeros.
    pub fn clear(&mut self, buffer: &Buffer) {
        self.encoder.clear_buffer(buffer, 0, None);
    }

    /// Fills a range of a buffer's words with zeros.
    pub fn clear_words(&mut self, buffer: &Buffer, words: std::ops::Range<u64>) {
        self.encoder.clear_buffer(buffer, 4 * words.start, Some(4 * (words.end - words.start)));
    }

    /// Copies `bytes` from the start of one buffer to the start of another.
    pub fn copy_buffer(&mut self, from: &Buffer, to: &Buffer, bytes: u64) {
        self.encoder.copy_buffer_to_buffer(from, 0, to, 0, bytes);
    }

    /// Copies a whole texture to one of the same size and format.
    pub fn copy_texture(&mut self, from: &Texture, to: &Texture) {
        self.encoder.copy_texture_to_texture(from.as_image_copy(), to.as_image_copy(), from.size());
    }

    /// One compute pass; `resources` in the order of the kernel's bindings, `workgroups` as a count per axis.
    pub fn compute(
        &mut self,
        pass: &str,
        kernel: &Kernel,
        resources: &[wgpu::BindingResource<'_>],
        workgroups: [u32; 3],
    ) {
        let [x, y, z] = workgroups;
        self.compute_pass(pass, kernel, resources, |recording| recording.dispatch_workgroups(x, y, z));
    }

    /// One compute pass whose workgroup count is three words of a buffer.
    pub fn compute_indirect(
        &mut self,
        pass: &str,
        kernel: &Kernel,
        resources: &[wgpu::BindingResource<'_>],
        workgroups: &Buffer,
        offset: u64,
    ) {
        self.compute_pass(pass, kernel, resources, |recording| {
            recording.dispatch_workgroups_indirect(workgroups, offset);
        });
    }

    fn compute_pass(
        &mut self,
        pass: &str,
        kernel: &Kernel,
        resources: &[wgpu::BindingResource<'_>],
        dispatch: impl FnOnce(&mut wgpu::ComputePass<'_>),
    ) {
        let groups = self.bind(&kernel.layout, &kernel.name, resources);
        let span = self.begin_span(pass);
        {
            let timestamp_writes = span.as_ref().map(Span::of_compute);
            let mut recording = self
                .encoder
                .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(pass), timestamp_writes });
            recording.set_pipeline(&kernel.pipeline);
            for (index, group) in (0u32..).zip(&groups) {
                recording.set_bind_group(index, group, &[]);
            }
            dispatch(&mut recording);
        }
        self.pass_done();
    }

    /// One raster pass over `vertices` pulled vertices.
    pub fn raster(
        &mut self,
        pass: &str,
        kernel: &RasterKernel,
        resources: &[wgpu::BindingResource<'_>],
        targets: &RasterTargets<'_>,
        vertices: std::ops::Range<u32>,
    ) {
        self.raster_pass(pass, kernel, resources, targets, |recording| recording.draw(vertices, 0..1));
    }

    /// One raster pass whose counts and first indices of vertices and instances are four words at the start of a buffer.
    pub fn raster_indirect(
        &mut self,
        pass: &str,
        kernel: &RasterKernel,
        resources: &[wgpu::BindingResource<'_>],
        targets: &RasterTargets<'_>,
        draw: &Buffer,
    ) {
        self.raster_pass(pass, kernel, resources, targets, |recording| recording.draw_indirect(draw, 0));
    }

    fn raster_pass(
        &mut self,
        pass: &str,
        kernel: &RasterKernel,
        resources: &[wgpu::BindingResource<'_>],
        targets: &RasterTargets<'_>,
        draw: impl FnOnce(&mut wgpu::RenderPass<'_>),
    ) {
        let groups = self.bind(&kernel.layout, &kernel.name, resources);
        let span = self.begin_span(pass);
        {
            let timestamp_writes = span.as_ref().map(|s| wgpu::RenderPassTimestampWrites {
                query_set: s.queries(),
                beginning_of_pass_write_index: Some(s.begin()),
                end_of_pass_write_index: Some(s.end()),
            });
            let colors: Vec<_> = targets
                .colors
                .iter()
                .map(|(view, clear)| {
                    let load = clear.map_or(wgpu::LoadOp::Load, wgpu::LoadOp::Clear);
                    Some(wgpu::RenderPassColorAttachment {
                        view,
                        depth_slice: None,
                        resolve_target: None,
                        ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
                    })
                })
                .collect();
            let mut recording = self.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(pass),
                color_attachments: &colors,
                depth_stencil_attachment: targets.depth.map(|(view, clear)| {
                    wgpu::RenderPassDepthStencilAttachment {
                        view,
                        depth_ops: Some(wgpu::Operations {
                            load: clear.map_or(wgpu::LoadOp::Load, wgpu::LoadOp::Clear),
                            store: wgpu::StoreOp::Store,
                        }),
                        stencil_ops: None,
                    }
                }),
                timestamp_writes,
                occlusion_query_set: None,
                multiview_mask: None,
            });
            recording.set_pipeline(&kernel.pipeline);
            for (index, group) in (0u32..).zip(&groups) {
                recording.set_bind_group(index, group, &[]);
            }
            draw(&mut recording);
        }
        self.pass_done();
    }

    /// Notes that `pass` wrote `texture`, so that a viewer or a test can ask for it by name. A later note under the same
    /// name replaces the earlier one.
    pub fn output(&mut self, pass: &str, texture: &Texture) {
        match self.outputs.iter_mut().find(|(name, _)| name == pass) {
            Some((_, noted)) => *noted = texture.clone(),
            None => self.outputs.push((pass.into(), texture.clone())),
        }
    }

    /// Notes a 64-bit counter (low word, high word) at a byte offset, read when the frame ends. Several counters of one
    /// name add up.
    pub fn counter(&mut self, name: &str, buffer: &Buffer, offset: u64) {
        self.counters.push((name.into(), buffer.clone(), offset));
    }

    fn bind(
        &self,
        layout: &Layout,
        name: &str,
        resources: &[wgpu::BindingResource<'_>],
    ) -> Vec<wgpu::BindGroup> {
        layout.bind(name, resources, |layout, entries| match self.comes_again {
            true => self.gpu.bind_groups.get(self.gpu, name, layout, entries),
            false => self.gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(name),
                layout,
                entries,
            }),
        })
    }

    fn begin_span(&mut self, pass: &str) -> Option<Span> {
        if let Some(mark) = self.timer.mark() {
            let timestamp_writes = Some(mark.of_compute());
            self.encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes });
        }
        self.timer.begin(pass)
    }

    fn pass_done(&mut self) {
        self.passes_in_slice += 1;
        if self.passes_in_slice >= PASSES_PER_SUBMIT || self.timer.is_full() {
            self.flush();
        }
    }

    /// A stage that records and cannot fail says what failed all the same; [`Recorder::finish`] returns it.
    pub fn fail(&mut self, error: GpuError) {
        self.failed.get_or_insert(error);
    }

    /// Submits what is recorded so far, and waits until at most one earlier slice is still running.
    pub fn flush(&mut self) {
        self.uniforms.upload(self.gpu);
        if let Err(e) = self.timer.resolve(self.gpu, &mut self.encoder) {
            self.failed.get_or_insert(e);
        }
        let next = self.gpu.device.create_command_encoder(&Default::default());
        let slice = std::mem::replace(&mut self.encoder, next).finish();
        if self.failed.is_some() {
            return;
        }
        let submitted = self.gpu.queue.submit([slice]);
        self.passes_in_slice = 0;
        if let Some(earlier) = self.in_flight.replace(submitted) {
            let wait = wgpu::PollType::Wait { submission_index: Some(earlier), timeout: None };
            if let Err(e) = self.gpu.device.poll(wait) {
                self.failed
                    .get_or_insert(GpuError::ReadBack { what: "a submit".into(), message: e.to_string() });
            }
        }
    }

    /// Submits the rest, waits, and reads times and counts.
    ///
    /// # Errors
    /// The device was lost or ran out of memory on the way.
    pub fn finish(mut self) -> Result<FrameLog, GpuError> {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let staging = self.gpu.lend("Recorder::counters", 8 * self.counters.len() as u64, usage)?;
        for (slot, (_, buffer, offset)) in (0u64..).zip(&self.counters) {
            self.encoder.copy_buffer_to_buffer(buffer, *offset, &staging, 8 * slot, 8);
        }
        self.flush();
        if let Some(failed) = self.failed {
            return Err(failed);
        }
        let words: Vec<u64> = bytemuck::pod_collect_to_vec(
            &self.gpu.map(&staging, "Recorder::counters")?[..8 * self.counters.len()],
        );
        let mut log =
            FrameLog { passes: self.timer.read(self.gpu)?, outputs: self.outputs, ..Default::default() };
        self.gpu.take_back(staging);
        self.uniforms.give_back(self.gpu);
        if self.comes_again {
            self.gpu.bind_groups.frame_is_over();
        }
        for ((name, ..), word) in self.counters.into_iter().zip(words) {
            *log.counts.entry(name).or_default() += word as f64;
        }
        Ok(log)
    }
}

#[cfg(test)]
mod tests;
