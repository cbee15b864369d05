//! Pictures as linear numbers, made smaller by averaging.
//!
//! In: 8-bit RGBA, sRGB or linear. Out: planes of four linear channels, smaller ones, and 8-bit again. A texel of a
//! smaller plane is the area-weighted mean of what it covers, so that the mean of the whole is kept whatever the sizes;
//! colours are averaged as light, not as codes. Averaged normals keep their shortened length.

use crate::surface::{linear_from_srgb, srgb_from_linear};
use glam::Vec4;

/// What the three colour channels of a picture mean; alpha is always linear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// sRGB codes.
    Srgb,
    /// Plain fractions of 255.
    Linear,
}

/// Linear texels, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plane {
    /// Columns and rows.
    pub size: [usize; 2],
    /// As many as the size says.
    pub texels: Vec<Vec4>,
}

impl Plane {
    /// Decodes 8-bit texels. With a threshold, alpha becomes 1 from this code on and 0 below: the mean of a mask's
    /// alpha then is the share that it leaves.
    pub(super) fn decode(
        size: [usize; 2],
        rgba: &[[u8; 4]],
        encoding: Encoding,
        threshold: Option<u16>,
    ) -> Self {
        let table: Vec<f32> = (0..=255u8)
            .map(|code| match encoding {
                Encoding::Srgb => linear_from_srgb(f32::from(code) / 255.0),
                Encoding::Linear => f32::from(code) / 255.0,
            })
            .collect();
        let alpha = |code: u8| match threshold {
            Some(threshold) => f32::from(u8::from(u16::from(code) >= threshold)),
            None => f32::from(code) / 255.0,
        };
        let texel = |&[r, g, b, a]: &[u8; 4]| {
            Vec4::new(table[usize::from(r)], table[usize::from(g)], table[usize::from(b)], alpha(a))
        };
        Self { size, texels: rgba.iter().map(texel).collect() }
    }

    /// As 8-bit texels, rounded to the nearest code.
    pub(super) fn encode(&self, encoding: Encoding) -> Vec<[u8; 4]> {
        let code = |x: f32| (255.0 * x).round().clamp(0.0, 255.0) as u8;
        let color = |x: f32| match encoding {
            Encoding::Srgb => code(srgb_from_linear(x)),
            Encoding::Linear => code(x),
        };
        self.texels.iter().map(|t| [color(t.x), color(t.y), color(t.z), code(t.w)]).collect()
    }

    /// The next mip: half the size, rounded down, at least 1.
    pub(super) fn mip(&self) -> Self {
        self.averaged(self.size.map(|n| (n / 2).max(1)))
    }

    /// A plane of this size, none of whose sides is longer than now.
    pub(super) fn averaged(&self, size: [usize; 2]) -> Self {
        let [columns, rows] = [0, 1].map(|axis| shares(self.size[axis], size[axis]));
        let mut texels = Vec::with_capacity(size[0] * size[1]);
        let mut narrow = vec![Vec4::ZERO; size[0]];
        for row in &rows {
            narrow.fill(Vec4::ZERO);
            for &(from_row, row_share) in row {
                let line = &self.texels[from_row * self.size[0]..][..self.size[0]];
                for (sum, column) in narrow.iter_mut().zip(&columns) {
                    *sum +=
                        column.iter().map(|&(from, share)| line[from] * (share * row_share)).sum::<Vec4>();
                }
            }
            texels.extend_from_slice(&narrow);
        }
        Self { size, texels }
    }
}

/// For each of `to` equal parts, which of `from` equal parts it covers and with what share of itself.
fn shares(from: usize, to: usize) -> Vec<Vec<(usize, f32)>> {
    let scale = from as f64 / to as f64;
    let part = |i: usize| {
        let (low, high) = (i as f64 * scale, (i + 1) as f64 * scale);
        let last = (high.ceil() as usize).min(from);
        (low as usize..last)
            .map(|j| (j, ((high.min((j + 1) as f64) - low.max(j as f64)) / scale) as f32))
            .filter(|(_, share)| *share > 1e-6)
            .collect()
    };
    (0..to).map(part).collect()
}
