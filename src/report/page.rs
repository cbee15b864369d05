//! `report.html`: one file that needs no network, with the pictures in it.
//!
//! The page is a template with four holes: title, style, data, script. The data is the report as JSON in a script block
//! of a type that browsers do not run, with every `<` written as `\u003c`, so that nothing in it can end the block; the
//! script puts text into the page as text only.

use super::{Report, merge, sentences, tables};
use crate::Error;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

const TEMPLATE: &str = include_str!("html/report.html");
const STYLE: &str = include_str!("html/report.css");
/// In order: each may use what those before it define.
const SCRIPTS: [&str; 7] = [
    include_str!("html/page.js"),
    include_str!("html/facts.js"),
    include_str!("html/pictures.js"),
    include_str!("html/axes.js"),
    include_str!("html/curves.js"),
    include_str!("html/table.js"),
    include_str!("html/measured.js"),
];

#[derive(Serialize)]
struct Data<'a> {
    report: &'a Report,
    sentences: Vec<String>,
    tables: Vec<tables::Table>,
    /// File to `data:` address.
    images: BTreeMap<&'a str, String>,
}

/// The whole file; pictures are read from `folder`.
///
/// # Errors
/// A picture that is not there.
pub fn text(report: &Report, folder: &Path) -> Result<String, Error> {
    let mut images = BTreeMap::new();
    for file in
        report.pictures.iter().flat_map(|picture| [Some(&picture.file), picture.heat.as_ref()]).flatten()
    {
        let png = merge::bytes(folder, file)?;
        images.insert(file.as_str(), format!("data:image/png;base64,{}", STANDARD.encode(png)));
    }
    let tables = tables::of(report.race.as_ref(), &report.defects);
    let data = Data { report, sentences: sentences::of(&report.answers), tables, images };
    let data = serde_json::to_string(&data)
        .map_err(|e| Error::Write { path: folder.join("report.html"), message: e.to_string() })?;
    Ok(fill(TEMPLATE, |hole| match hole {
        "title" => escaped(&report.facts.scene),
        "style" => STYLE.into(),
        "data" => data.replace('<', "\\u003c"),
        "script" => SCRIPTS.concat(),
        _ => String::new(),
    }))
}

/// Puts a value into each `{{hole}}`, in one go: what is put in is not looked at again.
fn fill(template: &str, value: impl Fn(&str) -> String) -> String {
    let mut parts = template.split("{{");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (hole, rest) = part.split_once("}}").unwrap_or((part, ""));
        text += &value(hole);
        text += rest;
    }
    text
}

/// As text within HTML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::report::synthetic::{self, Scratch};

    const HOSTILE: &str = "</script><script>alert(1)</script><!-- {{data}} \"&'";

    fn page(scene: &str) -> String {
        let scratch = Scratch::new(&format!("page-{}", scene.len()));
        synthetic::write_share(scratch.path(), Default::default());
        text(&synthetic::report(scene), scratch.path()).unwrap()
    }

    #[test]
    fn a_hostile_scene_name_ends_no_block_and_fills_no_hole() {
        let (hostile, tame) = (page(HOSTILE), page("cornell"));
        for tag in ["<script", "</script", "<!--", "<style", "<title"] {
            assert_eq!(hostile.matches(tag).count(), tame.matches(tag).count(), "{tag}");
        }
        assert!(hostile.contains("<title>&lt;/script&gt;&lt;script&gt;alert(1)"), "escaped in the title");
    }

    #[test]
    fn the_data_reads_back() {
        let page = page(HOSTILE);
        let (_, rest) = page.split_once("<script type=\"application/json\" id=\"data\">").unwrap();
        let (data, _) = rest.split_once("</script>").unwrap();
        let data: serde_json::Value = serde_json::from_str(data).unwrap();
        assert_eq!(data["report"]["scene"], HOSTILE);
        let png = data["images"]["reference_bvh.png"].as_str().unwrap();
        let png = STANDARD.decode(png.strip_prefix("data:image/png;base64,").unwrap()).unwrap();
        assert!(png.starts_with(b"\x89PNG"));
    }

    #[test]
    fn the_page_asks_nobody_for_anything() {
        let page = page("cornell");
        // The one address is the name of SVG, which is not fetched.
        let page = page.replace("http://www.w3.org/2000/svg", "");
        for sign in ["http:", "https:", "src=\"//", "@import", "url("] {
            assert!(!page.contains(sign), "{sign}");
        }
    }

    #[test]
    fn a_picture_that_is_not_there_is_named() {
        let scratch = Scratch::new("page-missing");
        let message = text(&synthetic::report("cornell"), scratch.path()).unwrap_err().to_string();
        assert!(message.contains("reference_bvh.png"), "{message}");
    }
}
