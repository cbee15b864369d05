fn record_light(index: u32) -> u32 {
    return grid_records[RECORD_WORDS * index + RECORD_LIGHT_AT];
}
