//! Bends: cells in which triangles are not one surface have no plane that tells its sides.
//!
//! In: the winner of each cell, and every triangle of it, as whoever voted finds them. Out: a bit per cell of a batch of
//! bricks, 16 words each, for [`crate::resolve`].
//!
//! A cell is bent where the normal of one of its triangles is too far from the winner's, seen from either side, or the
//! triangle is too far from the winner's plane ([`Bend`]); and where one of them moves and another stands still, so that
//! [`crate::revoxelize`] need not look at those that stand still again. What lets light through has no bend.

pub(crate) const WGSL: &str = include_str!("bend.inc.wgsl");

/// Words per brick: a bit per cell.
pub(crate) const BEND_WORDS: u32 = crate::grid::BRICK_CELLS / 32;

/// Where triangles of a cell stop being one surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bend {
    /// Cosine between normals.
    pub(crate) flat: f32,
    /// Cells from one plane to the other.
    pub(crate) apart: f32,
}

impl Bend {
    /// Planes only tell sides: 30 degrees, and two sides of a sheet may share a cell.
    pub(crate) const OF_SIDES: Self = Self { flat: 0.866_025_4, apart: 1e9 };
    /// Planes are where surfaces are: 20 degrees, which are 0.15 cell at a cell's corner.
    pub(crate) const OF_CONTOURS: Self = Self { flat: 0.939_692_6, apart: 0.1 };

    /// Whether planes only tell sides.
    pub(crate) fn is_of_sides(self) -> bool {
        self.apart == Self::OF_SIDES.apart
    }

    /// By whether planes are met.
    pub(crate) fn of(contours: bool) -> Self {
        if contours { Self::OF_CONTOURS } else { Self::OF_SIDES }
    }
}
