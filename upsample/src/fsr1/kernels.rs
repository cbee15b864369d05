//! The two passes, compiled.

use super::{RcasParams, WORKGROUP};
use crate::modulate;
use frame::info::{self, Frame};
use frame::{Bind, ColorImage, Gpu, Kernel, KernelDesc, KernelError};

const TONE: &str = include_str!("tone.inc.wgsl");

/// EASU and RCAS.
pub(super) struct Kernels {
    pub(super) easu: Kernel,
    pub(super) rcas: Kernel,
}

impl Kernels {
    pub(super) fn new(gpu: &Gpu) -> Result<Self, KernelError> {
        let kernel = |entry: &'static str, sources: &[&str], bindings: &[Bind]| {
            let name = format!("upsample/fsr1/{entry}");
            let desc =
                KernelDesc { name: &name, sources, entry, workgroup: WORKGROUP, bindings, constants: &[] };
            Kernel::new(gpu, &desc)
        };
        let out = Bind::storage_texture(3, 0, "out_color", ColorImage::FORMAT);
        let easu = kernel(
            "easu",
            &[info::WGSL, frame::HALF_WGSL, TONE, include_str!("easu.wgsl")],
            &[Bind::uniform::<Frame>(0, 0, "frame"), Bind::texture(2, 6, "in_color"), out],
        )?;
        let last = [Bind::uniform::<RcasParams>(0, 1, "params"), Bind::texture(2, 6, "in_color"), out];
        let rcas = kernel(
            "rcas",
            &[&modulate::SOURCES[..], &[TONE, include_str!("rcas.wgsl")]].concat(),
            &[&modulate::BINDS[..7], &last].concat(),
        )?;
        Ok(Self { easu, rcas })
    }
}
