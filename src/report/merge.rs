//! `gridlight report merge`: joins the shards of a comparison into the report that one run would have written.
//!
//! Shards are folders with a `rows.json` and the pictures it names. They must be of one scene, at one size, on one
//! adapter (times of two adapters are not to be compared), against the same references. Rows are shared out, never
//! shared: one that turns up twice is refused.

use super::{Facts, Picture, ReferenceInfo, Report};
use crate::defects::Defects;
use crate::{Error, output};
use std::collections::BTreeMap;
use std::fmt::Debug;
use std::path::{Component, Path, PathBuf};

/// Why shards do not make one report.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// A file of a shard that is not there, or says something else.
    #[error("{path}: {message}", path = path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's words, or the parser's.
        message: String,
    },
    /// A fact on which two shards differ.
    #[error("{what} differs: {first} in {}, {second} in {}", first_shard.display(), second_shard.display())]
    Differs {
        /// The fact.
        what: String,
        /// A shard.
        first_shard: PathBuf,
        /// What it says.
        first: String,
        /// Another.
        second_shard: PathBuf,
        /// What that says.
        second: String,
    },
    /// A row that turns up twice.
    #[error("the row [{key}] is in {} and in {}", first_shard.display(), second_shard.display())]
    DuplicateRow {
        /// Its key.
        key: String,
        /// A shard.
        first_shard: PathBuf,
        /// Another, or the same.
        second_shard: PathBuf,
    },
    /// A picture's name leads out of its folder.
    #[error("{}: the picture {file:?} is not within the folder", shard.display())]
    Outside {
        /// The shard.
        shard: PathBuf,
        /// As named.
        file: String,
    },
}

/// A report with the folder it was read from.
struct Shard<'a> {
    folder: &'a Path,
    report: Report,
}

/// Reads the report of a folder from its `rows.json`.
///
/// # Errors
/// No such file, or one that is no report.
pub fn read(folder: &Path) -> Result<Report, MergeError> {
    let path = folder.join("rows.json");
    let fail = |message: String| MergeError::Read { path: path.clone(), message };
    let text = std::fs::read(&path).map_err(|e| fail(e.to_string()))?;
    serde_json::from_slice(&text).map_err(|e| fail(e.to_string()))
}

/// Joins the shards in `folders` and writes the whole to `out`, pictures included.
///
/// # Errors
/// Shards that cannot be read or do not belong together, or files that cannot be written.
pub fn merge(out: &Path, folders: &[PathBuf]) -> Result<Report, Error> {
    let shards = folders
        .iter()
        .map(|folder| Ok(Shard { folder, report: read(folder)? }))
        .collect::<Result<Vec<_>, MergeError>>()?;
    let facts = facts(&shards)?;
    let references = references(&shards)?;
    refuse_duplicates(&shards)?;
    let pictures = pictures(&shards)?;
    // Everything that can be refused has been: only now is anything written.
    output::folder(out)?;
    let mut joined: Vec<Picture> = Vec::new();
    for (picture, files) in pictures {
        for (file, bytes) in files {
            let path = out.join(file);
            path.parent().map_or(Ok(()), output::folder)?;
            output::write(&path, &bytes)?;
        }
        joined.push(picture);
    }
    let race = shards.iter().find_map(|shard| shard.report.race.clone());
    let defects = defects(&shards);
    let rows = shards.into_iter().flat_map(|shard| shard.report.rows).collect();
    let report = Report { race, defects, ..Report::new(facts, references, rows, joined) };
    report.write(out)?;
    Ok(report)
}

/// The facts all shards share, and their commands.
fn facts(shards: &[Shard]) -> Result<Facts, MergeError> {
    let Some((first, others)) = shards.split_first() else { return Ok(Facts::default()) };
    let mut facts = first.report.facts.clone();
    for other in others {
        let theirs = &other.report.facts;
        same("scene", first, &facts.scene, other, &theirs.scene)?;
        same("adapter", first, &facts.adapter, other, &theirs.adapter)?;
        same("trace size", first, &facts.trace_size, other, &theirs.trace_size)?;
        same("display size", first, &facts.display_size, other, &theirs.display_size)?;
        for command in &theirs.commands {
            if !facts.commands.contains(command) {
                facts.commands.push(command.clone());
            }
        }
    }
    Ok(facts)
}

/// Each reference once; a grid that only one shard has is no difference.
fn references(shards: &[Shard]) -> Result<Vec<ReferenceInfo>, MergeError> {
    let mut all: Vec<(&Shard, &ReferenceInfo)> = Vec::new();
    for shard in shards {
        for info in &shard.report.references {
            match all.iter().find(|(_, r)| (r.kind, r.grid) == (info.kind, info.grid)) {
                Some((first, reference)) => {
                    let grid = info.grid.map(|grid| format!(" of grid {grid}")).unwrap_or_default();
                    same(&format!("reference {}{grid}", info.kind), first, *reference, shard, info)?;
                }
                None => all.push((shard, info)),
            }
        }
    }
    Ok(all.into_iter().map(|(_, info)| info.clone()).collect())
}

/// Those of each grid once, from the first shard that has them: they hold noise and times of their own run.
fn defects(shards: &[Shard]) -> Vec<Defects> {
    let mut by_grid = BTreeMap::new();
    for defects in shards.iter().flat_map(|shard| &shard.report.defects) {
        by_grid.entry(defects.grid).or_insert_with(|| defects.clone());
    }
    by_grid.into_values().collect()
}

fn refuse_duplicates(shards: &[Shard]) -> Result<(), MergeError> {
    let mut all: Vec<_> =
        shards.iter().flat_map(|shard| shard.report.rows.iter().map(move |row| (row.key(), shard))).collect();
    all.sort_by_key(|(key, _)| *key);
    match all.windows(2).find_map(|pair| match pair {
        [(a, first), (b, second)] if a == b => Some((a, first, second)),
        _ => None,
    }) {
        Some((key, first, second)) => Err(MergeError::DuplicateRow {
            key: key.to_string(),
            first_shard: first.folder.into(),
            second_shard: second.folder.into(),
        }),
        None => Ok(()),
    }
}

/// Names of files with what is in them.
type Files = Vec<(String, Vec<u8>)>;

/// Each picture once, with its files. Shards that share one (the references) must have the same.
fn pictures(shards: &[Shard]) -> Result<Vec<(Picture, Files)>, MergeError> {
    let mut all: Vec<(&Shard, Picture, Files)> = Vec::new();
    for shard in shards {
        for picture in &shard.report.pictures {
            let files = std::iter::once(&picture.file)
                .chain(&picture.heat)
                .map(|file| Ok((file.clone(), bytes(shard.folder, file)?)))
                .collect::<Result<Files, MergeError>>()?;
            match all.iter().find(|(_, known, _)| known.id == picture.id) {
                Some((first, known, known_files)) => {
                    let what = format!("picture {}", picture.id);
                    same(&what, first, known, shard, picture)?;
                    let sizes =
                        |files: &Files| files.iter().map(|(_, bytes)| bytes.len()).collect::<Vec<_>>();
                    if known_files != &files {
                        let [first_bytes, second_bytes] = [known_files, &files].map(sizes);
                        return Err(differs(&what, first, &first_bytes, shard, &second_bytes));
                    }
                }
                None => all.push((shard, picture.clone(), files)),
            }
        }
    }
    Ok(all.into_iter().map(|(_, picture, files)| (picture, files)).collect())
}

/// A picture's file, read only from within its folder.
pub fn bytes(folder: &Path, file: &str) -> Result<Vec<u8>, MergeError> {
    let mut parts = Path::new(file).components().peekable();
    if parts.peek().is_none() || parts.any(|part| !matches!(part, Component::Normal(_))) {
        return Err(MergeError::Outside { shard: folder.into(), file: file.into() });
    }
    let path = folder.join(file);
    std::fs::read(&path).map_err(|e| MergeError::Read { path, message: e.to_string() })
}

fn same<T: PartialEq + Debug>(
    what: &str,
    a: &Shard,
    first: &T,
    b: &Shard,
    second: &T,
) -> Result<(), MergeError> {
    match first == second {
        true => Ok(()),
        false => Err(differs(what, a, first, b, second)),
    }
}

fn differs(what: &str, a: &Shard, first: &impl Debug, b: &Shard, second: &impl Debug) -> MergeError {
    MergeError::Differs {
        what: what.into(),
        first_shard: a.folder.into(),
        first: format!("{first:?}"),
        second_shard: b.folder.into(),
        second: format!("{second:?}"),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::report::synthetic::{self, Scratch};

    /// The report in `whole`, and dealt out to two shards.
    fn shards(scratch: &Scratch) -> (PathBuf, Vec<PathBuf>) {
        let folders = ["whole", "one", "two"].map(|name| scratch.path().join(name));
        for (folder, shard) in folders.iter().zip(["1/1", "1/2", "2/2"]) {
            synthetic::write_share(folder, shard.parse().unwrap());
        }
        let [whole, one, two] = folders;
        (whole, vec![one, two])
    }

    fn edit(folder: &Path, change: impl FnOnce(&mut Report)) {
        let mut report = read(folder).unwrap();
        change(&mut report);
        report.write(folder).unwrap();
    }

    #[test]
    fn two_shards_make_the_whole() {
        let scratch = Scratch::new("merge-whole");
        let (whole, parts) = shards(&scratch);
        let out = scratch.path().join("out");
        merge(&out, &parts).unwrap();
        for file in ["rows.csv", "rows.json", "report.md", "report.html", "images/0.png", "reference_bvh.png"]
        {
            let [ours, theirs] = [&out, &whole].map(|folder| std::fs::read(folder.join(file)).unwrap());
            assert!(ours == theirs, "{file} is not what one run wrote");
        }
    }

    #[test]
    fn race_and_defects_come_from_the_first_shard_that_has_them() {
        let scratch = Scratch::new("merge-race");
        let (_, parts) = shards(&scratch);
        edit(&parts[0], |report| report.defects = vec![synthetic::defects(256)]);
        edit(&parts[1], |report| {
            report.race = Some(synthetic::race());
            let other = Defects { flicker_voxels: 9.0, ..synthetic::defects(256) };
            report.defects = vec![synthetic::defects(128), other];
        });
        let merged = merge(&scratch.path().join("out"), &parts).unwrap();
        assert_eq!(merged.race, Some(synthetic::race()));
        assert_eq!(merged.defects, [synthetic::defects(128), synthetic::defects(256)]);
    }

    /// What is changed in a shard.
    type Change = fn(&mut Report);

    #[test]
    fn shards_that_do_not_belong_together_are_told_apart() {
        let cases: [(&str, Change); 5] = [
            ("scene differs: \"cornell\" in ", |r| r.facts.scene = "garden".into()),
            ("trace size differs: [640, 480]", |r| r.facts.trace_size = [320, 240]),
            ("adapter differs", |r| r.facts.adapter = "another".into()),
            ("reference bvh differs", |r| r.references[0].spp += 1),
            ("is not within the folder", |r| r.pictures[0].file = "../whole/reference_bvh.png".into()),
        ];
        for (expected, change) in cases {
            let scratch = Scratch::new("merge-differs");
            let (_, parts) = shards(&scratch);
            let mut report = read(&parts[1]).unwrap();
            change(&mut report);
            std::fs::write(parts[1].join("rows.json"), serde_json::to_vec(&report).unwrap()).unwrap();
            let message = merge(&scratch.path().join("out"), &parts).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
            assert!(!scratch.path().join("out").exists(), "a refusal leaves nothing behind");
        }
    }

    #[test]
    fn a_row_in_two_shards_is_refused_by_its_key() {
        let scratch = Scratch::new("merge-twice");
        let (whole, parts) = shards(&scratch);
        let key = read(&parts[0]).unwrap().rows[0].key().to_string();
        let message = merge(&scratch.path().join("out"), &[whole, parts[0].clone()]).unwrap_err().to_string();
        assert!(message.contains(&key) && message.contains("whole") && message.contains("one"), "{message}");
    }

    #[test]
    fn a_picture_of_one_name_and_two_contents_is_refused() {
        let scratch = Scratch::new("merge-picture");
        let (_, parts) = shards(&scratch);
        std::fs::write(parts[1].join("reference_bvh.png"), b"another").unwrap();
        let message = merge(&scratch.path().join("out"), &parts).unwrap_err().to_string();
        assert!(message.contains("picture reference bvh differs"), "{message}");
    }

    #[test]
    fn what_is_no_shard_is_named() {
        let scratch = Scratch::new("merge-broken");
        let (_, parts) = shards(&scratch);
        edit(&parts[0], |report| report.facts.commands.clear());
        std::fs::write(parts[1].join("rows.json"), b"{ \"rows\": 3 }").unwrap();
        let message = merge(&scratch.path().join("out"), &parts).unwrap_err().to_string();
        assert!(message.contains("rows.json"), "{message}");
        let gone = [parts[0].clone(), scratch.path().join("nobody")];
        let message = merge(&scratch.path().join("out"), &gone).unwrap_err().to_string();
        assert!(message.contains("nobody"), "{message}");
    }
}
