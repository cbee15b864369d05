// Nested levels, finest first, in one structure and one buffer of records; one of them is at hand. What they are:
// ../cascades/mod.rs, which also prints GRID_LEVELS above this text.

struct GridLevels {
    // What the boxes are around, m.
    eye: vec3f,
    // The last is the whole scene. Where there are fewer, the first have a negative reach: nothing is inside.
    levels: array<Grid, GRID_LEVELS>,
}

@group(1) @binding(18) var<uniform> grid_levels: GridLevels;

// The level at hand, and its number.
var<private> grid: Grid;
var<private> grid_number: u32;

fn grid_first_record() -> u32 {
    return grid.first_record;
}
