//! Paths from camera rays of their own, summed up unrounded: what images converge to.
//!
//! In: triangles for the camera rays, and any structure for the light; sky, lights, materials. Out: per pixel the sum of
//! the radiance of all paths (linear, times `radiance_scale`), of its square, and their number, all f32.
//!
//! Each sample is one path per pixel through a random point of it, box filter. What its camera ray meets is kept in f32;
//! from there on everything is as for a G-buffer: the same start, segments, lobes and modulators, so that tracers
//! converge to what they would show without rounding, filters and the G-buffer's one ray per pixel. Rows are traced in
//! bands, because a storage binding has 128 MiB: 224 bytes a pixel.

use super::kernels::Workshop;
use super::{
    COUNTER_NAMES, COUNTERS_BYTES, MOST_SEGMENTS, PATH_BYTES, PathBuild, PathSettings, Searched, Segments,
    Structure, of_scene, params, rounds,
};
use crate::noise::{self, Noise};
use frame::scene_gpu::GpuScene;
use frame::{Buffer, Gpu, GpuError, Kernel, Recorder, Room, Uniform};
use wgpu::BindingResource;

/// Bytes of `Pixel` in `pixel_camera.inc.wgsl`.
const PIXEL_BYTES: u64 = 208;
/// A vector of four floats.
const MOMENTS_BYTES: u64 = 16;

/// Kernels and buffers of one structure, one scene, one size.
pub(crate) struct CameraPaths {
    pass: &'static str,
    camera: Kernel,
    start: Kernel,
    segment: Kernel,
    moments: Kernel,
    paths: Buffer,
    pixels: Buffer,
    counters: Buffer,
    mask: Buffer,
    /// Two `vec4f` per pixel of the band: sum of radiance and number of samples; sum of squares.
    pub(crate) sums: Buffer,
    size: [u32; 2],
    /// Rows of a band.
    pub(crate) band: u32,
}

/// The resources of a sample.
pub(crate) struct Resources<'a> {
    /// Of the structure that camera rays are traced in.
    pub(crate) of_camera: &'a [BindingResource<'a>],
    /// That paths are traced in.
    pub(crate) of_paths: Searched<'a>,
}

impl CameraPaths {
    pub(crate) fn new(
        gpu: &Gpu,
        scene: &GpuScene,
        of_camera: &Structure,
        structure: &Structure,
        size: [u32; 2],
        settings: &PathSettings,
    ) -> Result<Self, GpuError> {
        let workshop = |structure| Workshop {
            gpu,
            structure,
            scene,
            // Another generator than that of the images this one is compared with.
            // And every bounce its own.
            build: PathBuild { noise: Noise::Reference, cache: false, ..settings.build },
            camera: true,
        };
        let largest = gpu.device.limits().max_storage_buffer_binding_size;
        let row_bytes = PIXEL_BYTES * u64::from(size[0]);
        let band = (largest / row_bytes).clamp(1, u64::from(size[1])) as u32;
        let texels = u64::from(size[0]) * u64::from(band);
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let buffer = |label, bytes| gpu.buffer(Room::Radiance, label, bytes, usage);
        Ok(Self {
            pass: structure.pass,
            camera: workshop(of_camera).camera_ray()?,
            start: workshop(structure).start()?,
            segment: workshop(structure).segment()?,
            moments: workshop(structure).moments()?,
            paths: buffer("CameraPaths::paths", PATH_BYTES * texels)?,
            pixels: buffer("CameraPaths::pixels", PIXEL_BYTES * texels)?,
            counters: buffer("CameraPaths::counters", COUNTERS_BYTES)?,
            mask: noise::upload_mask(gpu)?,
            sums: buffer("CameraPaths::sums", MOMENTS_BYTES * texels)?,
            size,
            band,
        })
    }

    /// Clears the sums, then adds samples `first` to `first + count - 1` of the rows from `first_row` on.
    pub(crate) fn record(
        &self,
        recorder: &mut Recorder<'_>,
        uniform: &Uniform,
        scene: &GpuScene,
        resources: &Resources<'_>,
        settings: &PathSettings,
        first_row: u32,
        samples: std::ops::Range<u32>,
    ) {
        recorder.clear(&self.counters);
        recorder.clear(&self.sums);
        let mut params = params(recorder.gpu(), scene, settings, &resources.of_paths, MOST_SEGMENTS);
        params.first_row = first_row;
        params.rows = self.band.min(self.size[1] - first_row);
        let groups = [self.size[0].div_ceil(8), params.rows.div_ceil(8), 1];
        let [camera, start, moments] =
            ["camera", "start", "moments"].map(|part| format!("{}/{part}", self.pass));
        let buffers = [&self.paths, &self.pixels, &self.counters].map(|b| b.as_entire_binding());
        let [_, pixels, counters] = &buffers;
        for sample in samples {
            params.first_sample = sample;
            let of_sample = recorder.uniform(&[params; 2]);
            let mut list =
                vec![uniform.binding(), of_sample.binding(), BindingResource::TextureView(scene.sky.view())];
            list.extend_from_slice(resources.of_camera);
            list.extend([pixels.clone(), counters.clone()]);
            recorder.compute(&camera, &self.camera, &list, groups);
            if params.bounces > 0 {
                let mut list = vec![uniform.binding(), of_sample.binding(), self.mask.as_entire_binding()];
                list.extend(of_scene(scene, resources.of_paths.lights));
                list.extend_from_slice(resources.of_paths.resources);
                list.extend_from_slice(&buffers);
                recorder.compute(&start, &self.start, &list, groups);
                let segments = Segments {
                    pass: self.pass,
                    kernel: &self.segment,
                    uniform,
                    params: &of_sample,
                    rounds: rounds(&params, scene),
                    endless: settings.bounces.is_none(),
                    groups,
                };
                segments.record(recorder, scene, &resources.of_paths, &buffers, &self.counters);
            }
            let list = [
                uniform.binding(),
                of_sample.binding(),
                scene.brdf_table.as_entire_binding(),
                pixels.clone(),
                self.sums.as_entire_binding(),
            ];
            recorder.compute(&moments, &self.moments, &list, groups);
        }
        for (slot, name) in (0u64..).zip(COUNTER_NAMES) {
            recorder.counter(name, &self.counters, 8 * slot);
        }
    }
}
