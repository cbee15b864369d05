//! What travels between passes, and what runs them.
//!
//! [`Gpu`] is the device, [`Kernel`] a checked shader, [`Recorder`] one frame being recorded, [`scene_gpu`] the scene
//! uploaded; the rest is the data contract: [`surface`], [`brdf`], [`GBuffer`], [`RadianceImage`], [`FrameInfo`].

// The macro `gpu_struct!` names this crate by the name its users give it.
extern crate self as frame;

mod alias;
pub mod brdf;
pub mod cpu;
mod gpu;
mod images;
pub mod info;
mod kernel;
mod knob;
mod recorder;
pub mod scan;
pub mod scene_gpu;
pub mod surface;

pub use alias::Alias;
#[doc(hidden)]
pub use bytemuck;
pub use gpu::{ADAPTER_VARIABLE, Buffer, Gpu, GpuError, Memory, Room, Texture};
pub use images::{ColorImage, GBuffer, HALF_WGSL, RadianceImage};
pub use info::FrameInfo;
pub use kernel::{
    Bind, BindKind, Field, GpuStruct, Kernel, KernelDesc, KernelError, RasterDesc, RasterKernel,
};
pub use knob::{Knob, KnobError, KnobValue, set_knob};
pub use recorder::{FrameLog, PassLog, RasterTargets, Recorder, Uniform};
