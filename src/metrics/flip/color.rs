//! The colour spaces of FLIP: linear Rec. 709, CIE XYZ relative to white, the linear opponent space YCxCz, CIELAB.

use glam::{Mat3, Vec3};

/// XYZ from linear Rec. 709, columns per primary: IEC 61966-2-1's primaries and D65 in exact fractions.
fn xyz_from_linear() -> Mat3 {
    Mat3::from_cols(
        Vec3::new(10_135_552.0 / 24_577_794.0, 2_613_072.0 / 12_288_897.0, 1_425_312.0 / 73_733_382.0),
        Vec3::new(8_788_810.0 / 24_577_794.0, 8_788_810.0 / 12_288_897.0, 8_788_810.0 / 73_733_382.0),
        Vec3::new(4_435_075.0 / 24_577_794.0, 887_015.0 / 12_288_897.0, 70_074_185.0 / 73_733_382.0),
    )
}

/// Matrices between linear colour and XYZ over white, in which white is (1, 1, 1).
pub(super) struct Spaces {
    relative_from_linear: Mat3,
    linear_from_relative: Mat3,
}

impl Spaces {
    pub(super) fn new() -> Self {
        let white = xyz_from_linear() * Vec3::ONE;
        let relative_from_linear = Mat3::from_diagonal(white.recip()) * xyz_from_linear();
        Self { relative_from_linear, linear_from_relative: relative_from_linear.inverse() }
    }

    /// Y, Cx (red against green), Cz (blue against yellow): CIELAB without its curve.
    pub(super) fn opponent_from_linear(&self, linear: Vec3) -> Vec3 {
        opponents(self.relative_from_linear * linear)
    }

    /// The way back.
    pub(super) fn linear_from_opponent(&self, opponent: Vec3) -> Vec3 {
        let y = relative_luminance(opponent.x);
        self.linear_from_relative * Vec3::new(y + opponent.y / 500.0, y, y - opponent.z / 200.0)
    }

    /// CIELAB, with the Hunt effect: chroma counts by lightness.
    pub(super) fn hunt_lab_from_linear(&self, linear: Vec3) -> Vec3 {
        const DELTA: f32 = 6.0 / 29.0;
        let curve = |t: f32| match t > DELTA * DELTA * DELTA {
            true => t.cbrt(),
            false => t / (3.0 * DELTA * DELTA) + 4.0 / 29.0,
        };
        let relative = self.relative_from_linear * linear;
        let lab = opponents(Vec3::new(curve(relative.x), curve(relative.y), curve(relative.z)));
        let chroma = 0.01 * lab.x;
        Vec3::new(lab.x, chroma * lab.y, chroma * lab.z)
    }
}

fn opponents(v: Vec3) -> Vec3 {
    Vec3::new(116.0 * v.y - 16.0, 500.0 * (v.x - v.y), 200.0 * (v.y - v.z))
}

/// Luminance over white's from the opponent space's Y.
pub(super) fn relative_luminance(y: f32) -> f32 {
    (y + 16.0) / 116.0
}

/// City block in lightness, Euclid in chroma (Abasi, Tehran, Fairchild 2020): made for large differences.
pub(super) fn hyab(a: Vec3, b: Vec3) -> f32 {
    let d = a - b;
    d.x.abs() + d.y.hypot(d.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_neutral_and_the_opponent_space_leads_back() {
        let spaces = Spaces::new();
        // CIE: white has L* 100; f32 leaves 1e-4 of the difference of two terms of 500.
        assert!(spaces.hunt_lab_from_linear(Vec3::ONE).abs_diff_eq(Vec3::new(100.0, 0.0, 0.0), 2e-4));
        assert!(spaces.hunt_lab_from_linear(Vec3::ZERO).abs_diff_eq(Vec3::ZERO, 2e-4));
        // sRGB red in CIELAB is (53.24, 80.09, 67.20) for D65.
        let red = spaces.hunt_lab_from_linear(Vec3::X);
        assert!(red.abs_diff_eq(Vec3::new(53.24, 0.5324 * 80.09, 0.5324 * 67.20), 0.02), "{red}");
        for color in [Vec3::new(0.2, 0.7, 0.05), Vec3::X, Vec3::ONE] {
            let back = spaces.linear_from_opponent(spaces.opponent_from_linear(color));
            // Three matrices in f32.
            assert!(back.abs_diff_eq(color, 1e-5), "{color} became {back}");
        }
    }

    #[test]
    fn hyab_is_a_city_block_between_lightness_and_chroma() {
        assert_eq!(hyab(Vec3::new(10.0, 3.0, 0.0), Vec3::new(8.0, 0.0, 4.0)), 7.0);
    }
}
