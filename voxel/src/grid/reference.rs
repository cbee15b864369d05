//! The CPU half: the same structure built from a list of cells, and the same walk in f32.

use super::{BASE_WORD, BRICK_WORDS, EMPTY, Grid, Layout, PARTS_BIT, PREFIX_WORD, SLOTS, STEPS_PER_CELL};
use frame::surface::{CONTOUR_STEP, CREASE_CODE, normal_unpack};
use glam::{BVec3, IVec3, Vec3};

const STILL: f32 = 9.094_947e-13;
const FAR: f32 = 1e30;
const LONGEST: f32 = 1e12;
const NEAR: f32 = 8.0;
const NEAR_PLANES: f32 = 2.0;
/// Less than this behind a surface near its start a ray that leaves an opaque surface is taken to be in front of it.
pub const BEHIND: f32 = 0.75;
const CRACK: f32 = 0.1;
const SLACK: f32 = 0.02;

/// A grid in main memory.
#[derive(Clone, Debug)]
pub struct CpuGrid {
    /// As shaders have it.
    pub grid: Grid,
    /// As shaders have it.
    pub structure: Vec<u32>,
    /// Occupied cells.
    pub voxel_count: u32,
}

/// One block of a walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visit {
    /// The cell entered.
    pub cell: IVec3,
    /// Side of the empty block around it; 0 = occupied.
    pub empty: i32,
    /// Where it is entered, voxels along the ray.
    pub t: f32,
    /// Of the face it is entered through; 3 = the start.
    pub axis: u32,
}

/// How a walk ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Walk {
    /// Blocks visited.
    pub iterations: u32,
    /// The step limit ended it.
    pub cut: bool,
}

/// A cell that was met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Metres.
    pub distance: f32,
    /// Occupied.
    pub cell: IVec3,
    /// Index of its record.
    pub record: u32,
    /// Of the face it is entered through; 3 = the start.
    pub axis: u32,
}

/// As `GridHit` in the shader, for hits only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    /// Where.
    pub hit: Hit,
    /// The cell has no plane, its cube is met.
    pub is_cube: bool,
    /// Of the plane as stored.
    pub normal: Vec3,
    /// A point on the ray's side of the surface, voxels in grid space.
    pub beside: Vec3,
}

fn index(p: IVec3, size: [i32; 3]) -> usize {
    (p.x + size[0] * (p.y + size[1] * p.z)) as usize
}

fn empty_side(mask: [u32; 2], p: IVec3) -> i32 {
    if mask == [0, 0] {
        return 4;
    }
    empty_side_within(if p.z >= 2 { mask[1] } else { mask[0] }, p)
}

fn empty_side_within(layers: u32, p: IVec3) -> i32 {
    if (layers >> (p.x + 4 * p.y + 16 * (p.z & 1))) & 1 != 0 {
        return 0;
    }
    if (layers >> ((p.x & 2) + 4 * (p.y & 2))) & 0x0033_0033 == 0 { 2 } else { 1 }
}

/// Mask and bit of a cell (or brick, or group) within its parent's 4^3 mask.
fn bit_of(p: IVec3) -> (usize, u32) {
    ((p.z & 3) as usize / 2, ((p.x & 3) + 4 * (p.y & 3) + 16 * (p.z & 1)) as u32)
}

/// Which of a brick's masks holds the cell.
fn part(cell: IVec3) -> usize {
    let p: IVec3 = (cell >> 2) & IVec3::ONE;
    (p.x + 2 * p.y + 4 * p.z) as usize
}

impl CpuGrid {
    /// Builds the structure over these cells, in any order, repeats allowed. Cells outside the grid are left out.
    pub fn new(layout: &Layout, occupied: impl IntoIterator<Item = IVec3>) -> Self {
        let grid = layout.uniform(0);
        let mut structure = vec![0; grid.bricks_at as usize];
        structure[grid.table_at as usize..].fill(EMPTY);
        let inside: Vec<IVec3> = occupied
            .into_iter()
            .filter(|c| c.cmpge(IVec3::ZERO).all() && c.cmplt(IVec3::from(grid.cells)).all())
            .collect();
        for &cell in &inside {
            let (group, region) = (cell >> 5, cell >> 7);
            let (word, bit) = bit_of(cell >> 3);
            structure[grid.groups_at as usize + 2 * index(group, grid.groups) + word] |= 1 << bit;
            let (word, bit) = bit_of(group);
            structure[2 * index(region, grid.regions) + word] |= 1 << bit;
            structure[grid.table_at as usize + index(cell >> 3, grid.bricks)] = 0;
        }
        let mut built = Self { grid, structure, voxel_count: 0 };
        built.fill_sides();
        let structure = &mut built.structure;
        // Slots in the order of brick cells, as the scan on the device gives them.
        let mut slots = 0;
        for entry in structure[grid.table_at as usize..].iter_mut().filter(|entry| **entry < EMPTY) {
            *entry = slots;
            slots += 1;
        }
        structure.resize(structure.len() + (BRICK_WORDS * slots) as usize, 0);
        for cell in inside {
            let (word, bit) = bit_of(cell);
            let at = built.brick_at(cell) + 2 * part(cell) + word;
            built.structure[at] |= 1 << bit;
            let entry = built.entry_at(cell);
            built.structure[entry] |= 1 << (PARTS_BIT as usize + part(cell));
        }
        for brick in built.structure[grid.bricks_at as usize..].chunks_exact_mut(BRICK_WORDS as usize) {
            brick[BASE_WORD as usize] = built.voxel_count;
            let mut before = 0;
            for part in 0..8 {
                brick[PREFIX_WORD as usize + part / 2] |= before << (16 * (part & 1));
                before += brick[2 * part].count_ones() + brick[2 * part + 1].count_ones();
            }
            built.voxel_count += before;
        }
        built
    }

    fn mask(&self, at: usize) -> [u32; 2] {
        [self.structure[at], self.structure[at + 1]]
    }

    /// Tells every empty brick cell how far the emptiness around it goes.
    fn fill_sides(&mut self) {
        let [x, y, z] = self.grid.bricks;
        let bricks = (0..z).flat_map(|z| (0..y).flat_map(move |y| (0..x).map(move |x| IVec3::new(x, y, z))));
        for brick in bricks {
            let at = self.entry_at(brick << 3);
            if self.structure[at] == EMPTY {
                let (group, region) = (brick >> 2, brick >> 4);
                let groups_at = self.grid.groups_at as usize;
                let bricks = empty_side(self.mask(groups_at + 2 * index(group, self.grid.groups)), brick & 3);
                let groups = empty_side(self.mask(2 * index(region, self.grid.regions)), group & 3);
                self.structure[at] += if bricks == 4 { 32 * groups as u32 } else { 8 * bricks as u32 };
            }
        }
    }

    fn entry_at(&self, cell: IVec3) -> usize {
        self.grid.table_at as usize + index(cell >> 3, self.grid.bricks)
    }

    fn brick_at(&self, cell: IVec3) -> usize {
        (self.grid.bricks_at + BRICK_WORDS * (self.structure[self.entry_at(cell)] & SLOTS)) as usize
    }

    fn block(&self, cell: IVec3) -> i32 {
        let entry = self.structure[self.entry_at(cell)];
        if entry >= EMPTY {
            return (entry - EMPTY) as i32;
        }
        let part = part(cell);
        if (entry >> (PARTS_BIT as usize + part)) & 1 == 0 {
            return 4;
        }
        let word = self.brick_at(cell) + 2 * part + bit_of(cell).0;
        empty_side_within(self.structure[word], cell & 3)
    }

    /// Whether a cell is inside the grid and holds something.
    pub fn occupied(&self, cell: IVec3) -> bool {
        cell.cmpge(IVec3::ZERO).all()
            && cell.cmplt(IVec3::from(self.grid.cells)).all()
            && self.block(cell) == 0
    }

    /// Index of an occupied cell's record.
    pub fn record(&self, cell: IVec3) -> Option<u32> {
        if !self.occupied(cell) {
            return None;
        }
        let (brick, part) = (self.brick_at(cell), part(cell));
        let mask = self.mask(brick + 2 * part);
        let prefix = (self.structure[brick + PREFIX_WORD as usize + part / 2] >> (16 * (part & 1))) & 0xffff;
        let (word, bit) = bit_of(cell);
        let rank =
            (mask[word] & ((1 << bit) - 1)).count_ones() + if word == 1 { mask[0].count_ones() } else { 0 };
        Some(self.structure[brick + BASE_WORD as usize] + prefix + rank)
    }

    /// All occupied cells, brick by brick.
    pub fn cells(&self) -> Vec<IVec3> {
        let Grid { table_at, bricks_at, bricks, .. } = self.grid;
        let table = &self.structure[table_at as usize..bricks_at as usize];
        let mut cells = Vec::new();
        for (index, entry) in (0i32..).zip(table).filter(|(_, entry)| **entry < EMPTY) {
            let brick =
                IVec3::new(index % bricks[0], index / bricks[0] % bricks[1], index / (bricks[0] * bricks[1]));
            let at = (bricks_at + BRICK_WORDS * (entry & SLOTS)) as usize;
            for (bit, word) in
                (0i32..16).flat_map(|word| (0i32..32).map(move |bit| (32 * (word & 1) + bit, word)))
            {
                if (self.structure[at + word as usize] >> (bit & 31)) & 1 == 1 {
                    let part = word / 2;
                    let corner = 4 * IVec3::new(part & 1, (part >> 1) & 1, part >> 2);
                    cells.push(8 * brick + corner + IVec3::new(bit & 3, (bit >> 2) & 3, bit >> 4));
                }
            }
        }
        cells
    }

    /// Visits the blocks along a ray given in grid space, until `visit` says false, the grid ends or `t` passes `limit`
    /// (voxels).
    pub fn walk(&self, o: Vec3, d: Vec3, limit: f32, mut visit: impl FnMut(Visit) -> bool) -> Walk {
        let mut walk = Walk::default();
        let still = d.abs().cmplt(Vec3::splat(STILL));
        let forward = d.cmpgt(Vec3::ZERO);
        let inverse = Vec3::select(still, Vec3::ZERO, 1.0 / Vec3::select(still, Vec3::ONE, d));
        let cells = IVec3::from(self.grid.cells);
        let size = cells.as_vec3();
        if (still & (o.cmplt(Vec3::ZERO) | o.cmpge(size))).any() {
            return walk;
        }
        let enter = (Vec3::select(forward, Vec3::ZERO, size) - o) * inverse;
        let leave = (Vec3::select(forward, size, Vec3::ZERO) - o) * inverse;
        let enter = Vec3::select(still, Vec3::splat(-FAR), enter);
        let leave = Vec3::select(still, Vec3::splat(FAR), leave);
        let entered = enter.max_element();
        let mut t = entered.max(0.0);
        if t >= leave.min_element() || t > limit {
            return walk;
        }
        let mut cell = (o + t * d).floor().as_ivec3().clamp(IVec3::ZERO, cells - 1);
        let mut axis = 3;
        if entered > 0.0 {
            let x = enter.x >= enter.y && enter.x >= enter.z;
            let y = !x && enter.y >= enter.z;
            cell = IVec3::select(
                BVec3::new(x, y, !x && !y),
                IVec3::select(forward, IVec3::ZERO, cells - 1),
                cell,
            );
            axis = if x { 0 } else { 2 - u32::from(y) };
        }
        let ahead = IVec3::select(forward, IVec3::NEG_ONE, IVec3::ZERO);
        let onward = IVec3::select(forward, IVec3::ONE, IVec3::NEG_ONE);
        for _ in 0..STEPS_PER_CELL * cells.max_element() as u32 {
            walk.iterations += 1;
            let empty = self.block(cell);
            if !visit(Visit { cell, empty, t, axis }) {
                return walk;
            }
            let side = IVec3::splat(empty.max(1));
            let plane = (cell & -side) + (side & ahead);
            let exits = Vec3::select(still, Vec3::splat(FAR), (plane.as_vec3() - o) * inverse);
            let x = exits.x <= exits.y && exits.x <= exits.z;
            let y = !x && exits.y <= exits.z;
            axis = if x { 0 } else { 2 - u32::from(y) };
            t = t.max(exits.min_element());
            let last = plane + ahead;
            let there = (o + t * d).as_ivec3().clamp(cell.min(last), cell.max(last));
            cell = IVec3::select(BVec3::new(x, y, !x && !y), last + onward, there);
            if t > limit || (cell.cmplt(IVec3::ZERO) | cell.cmpge(cells)).any() {
                return walk;
            }
        }
        walk.cut = true;
        walk
    }

    /// The first occupied cell along a ray in the world.
    pub fn trace(&self, origin: Vec3, direction: Vec3, t_max: f32) -> (Option<Hit>, Walk) {
        self.first(origin, direction, t_max, |_, visit| Some(visit.t))
    }

    /// As `grid_trace`: the first surface along a ray in the world. `beside` is a point that no surface separates from the
    /// origin; it may lie `behind` by so many voxels and is in front all the same.
    pub fn trace_surfaces(
        &self,
        records: &[[u32; 4]],
        origin: Vec3,
        direction: Vec3,
        t_max: f32,
        (beside, behind): (Vec3, f32),
    ) -> (Option<SurfaceHit>, Walk) {
        let o = (origin - Vec3::from(self.grid.origin)) / self.grid.voxel_size;
        let mut side = (beside - Vec3::from(self.grid.origin)) / self.grid.voxel_size;
        let reach = if self.grid.contours != 0 { NEAR_PLANES } else { NEAR };
        let (mut start, mut near, mut is_after_empty) = (None, 0.0, false);
        let mut met = (false, Vec3::ZERO);
        let (hit, walk) = self.first(origin, direction, t_max, |grid, visit| {
            let first = *start.get_or_insert_with(|| {
                near = visit.t + reach;
                visit.cell
            });
            if visit.empty > 0 {
                is_after_empty = true;
                return None;
            }
            let center = visit.cell.as_vec3() + 0.5;
            if std::mem::take(&mut is_after_empty) && visit.t > near {
                let axis = visit.axis as usize;
                side = center - Vec3::AXES[axis] * direction[axis].signum();
            }
            let record = records[grid.record(visit.cell)? as usize];
            let code = record[1] as i32 >> 24;
            met = (code == CREASE_CODE, normal_unpack(record[0]));
            let t = if met.0 {
                (visit.cell != first).then_some(visit.t)
            } else {
                let (plane, ray) =
                    ((met.1, code as f32 * CONTOUR_STEP), (o + visit.t * direction - center, direction));
                let chord = (grid.exit(visit.cell, o, direction) - visit.t).max(0.0);
                let ahead = cross(
                    plane,
                    ray,
                    chord,
                    (side - center, behind),
                    visit.t <= near,
                    grid.grid.contours != 0,
                );
                ahead.map(|ahead| visit.t + ahead)
            };
            if t.is_none() {
                near = near.max(visit.t + reach);
            }
            t
        });
        (hit.map(|hit| SurfaceHit { hit, is_cube: met.0, normal: met.1, beside: side }), walk)
    }

    /// The first occupied cell, or empty one, that `meets` gives a distance for, in voxels.
    fn first(
        &self,
        origin: Vec3,
        direction: Vec3,
        t_max: f32,
        mut meets: impl FnMut(&Self, Visit) -> Option<f32>,
    ) -> (Option<Hit>, Walk) {
        let voxel_size = self.grid.voxel_size;
        let o = (origin - Vec3::from(self.grid.origin)) / voxel_size;
        let limit = t_max.min(LONGEST * voxel_size) / voxel_size;
        let mut hit = None;
        let walk = self.walk(o, direction, limit, |visit| {
            hit = meets(self, visit).filter(|_| visit.empty == 0).map(|t| (visit, t));
            hit.is_none()
        });
        let hit = hit.filter(|(_, t)| *t <= limit).and_then(|(visit, t)| {
            let record = self.record(visit.cell)?;
            Some(Hit { distance: (t * voxel_size).min(t_max), cell: visit.cell, record, axis: visit.axis })
        });
        (hit, walk)
    }

    /// Where a ray in grid space leaves a cell, voxels.
    fn exit(&self, cell: IVec3, o: Vec3, d: Vec3) -> f32 {
        let still = d.abs().cmplt(Vec3::splat(STILL));
        let inverse = Vec3::select(still, Vec3::ZERO, 1.0 / Vec3::select(still, Vec3::ONE, d));
        let plane = cell + IVec3::select(d.cmpgt(Vec3::ZERO), IVec3::ONE, IVec3::ZERO);
        Vec3::select(still, Vec3::splat(FAR), (plane.as_vec3() - o) * inverse).min_element()
    }
}

/// As `grid_cross`, from where the ray enters the cell: voxels on.
fn cross(
    plane: (Vec3, f32),
    ray: (Vec3, Vec3),
    chord: f32,
    (beside, behind): (Vec3, f32),
    is_near: bool,
    contours: bool,
) -> Option<f32> {
    let ((normal, offset), (from, direction)) = (plane, ray);
    let slope = normal.dot(direction);
    let side = normal.dot(beside) - offset;
    let behind = if contours { behind.min(CRACK) } else { behind };
    if is_near && (if slope > 0.0 { side > -behind } else { side < 0.0 }) {
        return None;
    }
    if !contours {
        return Some(0.0);
    }
    let height = (normal.dot(from) - offset) * if slope > 0.0 { -1.0 } else { 1.0 };
    let ahead = height.max(0.0) / slope.abs().max(1e-6);
    (height >= -CRACK && ahead <= chord + SLACK).then_some(ahead)
}
