//! `gridlight list`: scenes, stages, and their knobs with unit, range and default.

use super::args::ListArgs;
use super::{json, print};
use crate::Error;
use crate::stages::{self, Kind, KnobInfo};
use frame::Gpu;
use serde::Serialize;
use std::fmt::Write;

#[derive(Serialize)]
struct Listing {
    scenes: Vec<SceneLine>,
    stages: Vec<Stage>,
    /// None where no adapter is there to ask.
    knobs: Option<Vec<Knobs>>,
}

#[derive(Serialize)]
struct SceneLine {
    name: &'static str,
    about: &'static str,
}

#[derive(Serialize)]
struct Stage {
    kind: Kind,
    ids: Vec<&'static str>,
}

#[derive(Serialize)]
struct Knobs {
    id: &'static str,
    knobs: Vec<KnobInfo>,
}

/// Lists everything that can be named.
pub fn run(args: &ListArgs) -> Result<(), Error> {
    let knobs = match Gpu::new(args.adapter.as_deref()) {
        Ok(gpu) => Some(stages::knobs(gpu)?.into_iter().map(|(id, knobs)| Knobs { id, knobs }).collect()),
        // Names need no adapter: someone about to install one can still read them.
        Err(e) => {
            eprintln!("warning: no knobs listed: {e}");
            None
        }
    };
    let listing = Listing {
        scenes: scene::built_in::all().iter().map(|(name, about, _)| SceneLine { name, about }).collect(),
        stages: Kind::ALL.iter().map(|kind| Stage { kind: *kind, ids: kind.ids() }).collect(),
        knobs,
    };
    print(&if args.json { json(&listing)? } else { listing.text() })
}

impl Listing {
    fn text(&self) -> String {
        let mut text = "scenes\n".to_owned();
        // Writing to a string cannot fail.
        for scene in &self.scenes {
            let _ = writeln!(text, "  {:10} {}", scene.name, scene.about);
        }
        for stage in &self.stages {
            let _ = writeln!(text, "\n{}s\n  {}", stage.kind.name(), stage.ids.join(" "));
        }
        for Knobs { id, knobs } in self.knobs.iter().flatten().filter(|k| !k.knobs.is_empty()) {
            let _ = writeln!(text, "\nknobs of {id}");
            let mut rest = knobs.iter().peekable();
            while let Some(KnobInfo { name, unit, allowed, default, doc, .. }) = rest.next() {
                let path = format!("{id}.{name}");
                let space = if unit.is_empty() { "" } else { " " };
                let _ = writeln!(text, "  {path:32} {default}{space}{unit}  [{allowed}]");
                // Knobs of one family share their words: once, below the last of them.
                if rest.peek().is_none_or(|next| next.doc != *doc) {
                    wrapped(&mut text, doc);
                }
            }
        }
        text
    }
}

/// Words in lines short enough to read.
fn wrapped(text: &mut String, words: &str) {
    const INDENT: &str = "      ";
    const COLUMNS: usize = 96;
    let mut line = INDENT.to_owned();
    for word in words.split_whitespace() {
        if line.len() + word.len() > COLUMNS && line != INDENT {
            text.push_str(line.trim_end());
            text.push('\n');
            line = INDENT.to_owned();
        }
        line.push_str(word);
        line.push(' ');
    }
    text.push_str(line.trim_end());
    text.push('\n');
}
