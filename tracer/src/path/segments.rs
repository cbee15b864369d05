//! The dispatches that take paths from their first vertex to their end.

use super::{ANY_ALIVE, PathParams, Searched, of_scene};
use frame::scene_gpu::GpuScene;
use frame::{Buffer, Kernel, Recorder, Uniform};

/// Dispatches that take every path to its end. A sheet passed at the first hit uses up no bounce: such a path has one
/// segment more.
pub(super) fn rounds(params: &PathParams, scene: &GpuScene) -> u32 {
    (params.bounces + u32::from(scene.needs.transmission)).div_ceil(params.segments)
}

/// The dispatches that advance one path per pixel.
pub(super) struct Segments<'a> {
    pub(super) pass: &'static str,
    pub(super) kernel: &'a Kernel,
    pub(super) uniform: &'a Uniform,
    pub(super) params: &'a Uniform,
    pub(super) rounds: u32,
    pub(super) endless: bool,
    pub(super) groups: [u32; 3],
}

impl Segments<'_> {
    /// `buffers` are paths, pixels, counters, and the cache if there is one.
    pub(super) fn record(
        &self,
        recorder: &mut Recorder<'_>,
        scene: &GpuScene,
        structure: &Searched<'_>,
        buffers: &[wgpu::BindingResource<'_>],
        counters: &Buffer,
    ) {
        let pass = format!("{}/segment", self.pass);
        let mut resources = vec![self.uniform.binding(), self.params.binding()];
        resources.extend(of_scene(scene, structure.lights));
        resources.extend_from_slice(structure.resources);
        resources.extend_from_slice(buffers);
        for round in 0..self.rounds {
            recorder.clear_words(counters, ANY_ALIVE..ANY_ALIVE + 1);
            recorder.compute(&pass, self.kernel, &resources, self.groups);
            if self.endless && round > 0 && none_alive(recorder, counters) {
                break;
            }
        }
    }
}

/// Whether the last dispatch left no path alive. Only asked where paths have no limit: it waits for the dispatch.
fn none_alive(recorder: &mut Recorder<'_>, counters: &Buffer) -> bool {
    recorder.flush();
    // Should reading fail, the device is gone, and the frame's end will say so.
    let words = recorder.gpu().read_buffer::<u32>(counters);
    words.is_ok_and(|words| words.get(ANY_ALIVE as usize) == Some(&0))
}
