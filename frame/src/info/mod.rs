//! What a frame is rendered with: camera, sizes, seed, time. One struct for Rust, one for shaders.

use glam::{Mat4, Vec3};
use scene::Camera;

/// The frame as shaders see it: `frame` at group 0, binding 0.
pub const WGSL: &str = include_str!("frame.inc.wgsl");

crate::gpu_struct! {
    /// See `frame.inc.wgsl`.
    pub struct Frame {
        /// Jittered.
        pub clip_from_world: [[f32; 4]; 4],
        /// Last frame's, jittered.
        pub previous_clip_from_world: [[f32; 4]; 4],
        /// Metres.
        pub eye: [f32; 3],
        /// 0 at a restart.
        pub frame_index: u32,
        /// Half the picture's width at distance 1.
        pub right: [f32; 3],
        /// Of all random numbers.
        pub seed: u32,
        /// Half the picture's height at distance 1.
        pub up: [f32; 3],
        /// Stored radiance = radiance times this power of two.
        pub radiance_scale: f32,
        /// Unit.
        pub forward: [f32; 3],
        /// Of the scene's bounds, metres.
        pub diagonal: f32,
        /// Pixels.
        pub trace_size: [u32; 2],
        /// Pixels.
        pub display_size: [u32; 2],
        /// Trace pixels.
        pub jitter: [f32; 2],
        /// Trace pixels.
        pub previous_jitter: [f32; 2],
        /// Seconds.
        pub time: f32,
        /// Seconds since the last frame.
        pub dt: f32,
        /// 1: forget all history.
        pub restart: u32,
        /// 1: first hits get their sun from a shadow map.
        pub sun_elsewhere: u32,
    }
}

/// What a frame is rendered with.
#[derive(Clone, Debug)]
pub struct FrameInfo {
    /// Where from.
    pub camera: Camera,
    /// Where from in the frame before; equal to `camera` at a restart.
    pub previous_camera: Camera,
    /// Pixels before upsampling.
    pub trace_size: [u32; 2],
    /// Pixels after upsampling; its aspect is the frustum's.
    pub display_size: [u32; 2],
    /// Offset of the sample point from the pixel centre, trace pixels, x right and y down.
    pub jitter: [f32; 2],
    /// The same in the frame before.
    pub previous_jitter: [f32; 2],
    /// 0 at a restart.
    pub frame_index: u32,
    /// Of all random numbers.
    pub seed: u32,
    /// Seconds of animation.
    pub time: f32,
    /// Seconds since the last frame.
    pub dt: f32,
    /// Power of two that stored radiance is multiplied with.
    pub radiance_scale: f32,
    /// Diagonal of the scene's bounds, metres.
    pub diagonal: f32,
    /// Forget all history.
    pub restart: bool,
    /// First hits get their sun from elsewhere.
    pub sun_elsewhere: bool,
}

impl FrameInfo {
    /// A first frame as plain as can be: one size, no jitter, seed 1, light unscaled, a scene of 1 m.
    pub fn still(camera: Camera, size: [u32; 2]) -> Self {
        Self {
            previous_camera: camera.clone(),
            camera,
            trace_size: size,
            display_size: size,
            jitter: [0.0; 2],
            previous_jitter: [0.0; 2],
            frame_index: 0,
            seed: 1,
            time: 0.0,
            dt: 0.0,
            radiance_scale: 1.0,
            diagonal: 1.0,
            restart: true,
            sun_elsewhere: false,
        }
    }

    /// Clip space from world space: reversed depth, infinite far plane, near plane at 1e-6 of the scene's diagonal.
    /// Reversed depth is as precise at any distance, so a near plane may be as near as a camera touches a wall.
    fn clip_from_world(&self, camera: &Camera, jitter: [f32; 2]) -> Mat4 {
        let [width, height] = self.display_size.map(|n| n as f32);
        let focal = 1.0 / (0.5 * camera.vfov).tan();
        let near = 1e-6 * self.diagonal.max(1e-6);
        let offset = [0, 1].map(|axis| 2.0 * jitter[axis] / self.trace_size[axis] as f32);
        // The picture moves against the sample point; y of clip space points up, y of jitter down. The view looks
        // along -z, so an offset proportional to w enters the third column with the opposite sign.
        let clip_from_view = Mat4::from_cols_array(&[
            focal * height / width,
            0.0,
            0.0,
            0.0,
            0.0,
            focal,
            0.0,
            0.0,
            offset[0],
            -offset[1],
            0.0,
            -1.0,
            0.0,
            0.0,
            near,
            0.0,
        ]);
        clip_from_view * camera.view_from_world()
    }

    /// The struct for shaders.
    pub fn uniform(&self) -> Frame {
        let [width, height] = self.display_size.map(|n| n as f32);
        let tan = (0.5 * self.camera.vfov).tan();
        let world_from_view = self.camera.view_from_world().inverse();
        let axis = |v: Vec3| world_from_view.transform_vector3(v);
        Frame {
            clip_from_world: self.clip_from_world(&self.camera, self.jitter).to_cols_array_2d(),
            previous_clip_from_world: self
                .clip_from_world(&self.previous_camera, self.previous_jitter)
                .to_cols_array_2d(),
            eye: self.camera.eye.into(),
            frame_index: self.frame_index,
            right: (tan * width / height * axis(Vec3::X)).into(),
            seed: self.seed,
            up: (tan * axis(Vec3::Y)).into(),
            radiance_scale: self.radiance_scale,
            forward: axis(Vec3::NEG_Z).into(),
            diagonal: self.diagonal,
            trace_size: self.trace_size,
            display_size: self.display_size,
            jitter: self.jitter,
            previous_jitter: self.previous_jitter,
            time: self.time,
            dt: self.dt,
            restart: u32::from(self.restart),
            sun_elsewhere: u32::from(self.sun_elsewhere),
        }
    }

    /// Trace rows per trace column, measured on the display: filter radii are in rows, and this many times that along a
    /// row (0.75 for 640x480 lifted to 1920x1080).
    pub fn columns_per_row(&self) -> f32 {
        let per = |axis: usize| self.display_size[axis] as f32 / self.trace_size[axis] as f32;
        per(1) / per(0)
    }
}

#[cfg(test)]
mod tests;
