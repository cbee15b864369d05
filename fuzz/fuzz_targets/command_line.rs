//! Command lines as typed or pasted: the viewer reads them back, so whatever is understood must come back the same.
#![no_main]

use gridlight::cli::RenderLine;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Ok(line) = std::str::from_utf8(bytes) else { return };
    // These two open files; what is in them is fuzzed elsewhere.
    if ["--path", "--case", "--pa", "--ca"].iter().any(|flag| line.contains(flag)) {
        return;
    }
    match line.parse::<RenderLine>() {
        Ok(understood) => {
            let written = understood.to_string();
            let again = written.parse::<RenderLine>();
            assert_eq!(again.as_ref(), Ok(&understood), "{written}");
        }
        Err(message) => assert!(!message.is_empty(), "refused without a word"),
    }
});
