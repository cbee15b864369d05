// Which patch an output element belongs to, after subdivide.inc.wgsl and SCAN_BLOCK.

// The last triangle whose elements begin at or before `element`. 24 halvings: as many triangles as an id has bits.
fn places_owner(element: u32) -> u32 {
    var low = 0u;
    var high = params.triangle_count;
    for (var i = 0u; i < 24u && high - low > 1u; i += 1u) {
        let middle = (low + high) / 2u;
        let is_after = places_before(middle) > element;
        low = select(middle, low, is_after);
        high = select(high, middle, is_after);
    }
    return low;
}
