fn record_lobe(index: u32) -> u32 {
    return grid_records[RECORD_WORDS * index + RECORD_LOBE_AT];
}
