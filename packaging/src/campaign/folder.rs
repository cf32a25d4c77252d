//! The folder of a campaign: what it is, the blocks that are done, the merged results.
//!
//! # Conventions
//! - `campaign.json` says everything that the results depend on. Whoever works in the folder must mean
//!   the same campaign.
//! - `blocks/000012.json` holds the rows of block 12, drives 192 to 207, and the campaign's digest; `sha256`, its last
//!   key, is that of all bytes before its comma. A block is there whole or not at all, whatever happens to the process or
//!   the machine; so a campaign that was cut short, or whose blocks come from several machines, goes on where blocks are
//!   missing.

use std::collections::BTreeSet;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::error::CampaignError;
use super::table::{self, Row};
use crate::bounded;
use crate::digest::sha256;
use crate::output;

/// Drives of a block.
pub const BLOCK: u64 = 16;

/// A folder that belongs to one campaign.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    drives: u64,
    /// The text of `campaign.json`, and its SHA-256.
    manifest: String,
    digest: String,
}

/// What stands between the bytes of a block and their digest.
const DIGEST: &str = ",\"sha256\":\"";

/// A file of `blocks/`, its digest apart.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BlockFile {
    campaign: String,
    rows: Vec<Row>,
}

impl Folder {
    /// Makes `path` the folder of the campaign that `manifest` describes, or finds that it is.
    ///
    /// # Errors
    /// [`CampaignError`] if it belongs to another campaign or cannot be read or made.
    pub fn open(
        path: &Path,
        drives: u64,
        manifest: &impl Serialize,
    ) -> Result<Self, CampaignError> {
        let manifest = serde_json::to_string_pretty(manifest)? + "\n";
        let digest = sha256(&manifest);
        let file = path.join("campaign.json");
        let blocks = path.join("blocks");
        output::create_folder(&blocks)?;
        // Where nothing is missing, nothing is written that would sweep them.
        output::temporary::sweep_files(path);
        output::temporary::sweep_files(&blocks);
        match bounded::read_text(&file) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                output::write(&file, manifest.as_bytes())?;
            }
            Err(error) => return Err(CampaignError::read(&file)(error)),
            Ok(there) if there == manifest => {}
            Ok(there) if is_damaged(&there) => return Err(CampaignError::Damaged { path: file }),
            Ok(there) => {
                let differences = differences(&there, &manifest);
                return Err(CampaignError::OtherCampaign { folder: path.to_owned(), differences });
            }
        }
        Ok(Self { path: path.to_owned(), drives, manifest, digest })
    }

    /// Number of blocks of the campaign.
    pub fn blocks(&self) -> u64 {
        self.drives.div_ceil(BLOCK)
    }

    /// Drives of block `block`.
    pub fn drives_of(&self, block: u64) -> Range<u64> {
        block * BLOCK..self.drives.min((block + 1) * BLOCK)
    }

    /// Writes the rows of a block.
    ///
    /// # Errors
    /// [`CampaignError::Output`].
    pub fn write_block(&self, block: u64, rows: Vec<Row>) -> Result<(), CampaignError> {
        let path = self.block_path(block);
        let file = BlockFile { campaign: self.digest.clone(), rows };
        let text = serde_json::to_string(&file)?;
        let bytes = text.strip_suffix('}').unwrap_or(&text);
        let text = format!("{bytes}{DIGEST}{}\"}}\n", sha256(bytes));
        Ok(output::write(&path, text.as_bytes())?)
    }

    /// The rows of a block; `None` if it is not done.
    ///
    /// # Errors
    /// [`CampaignError`] if the file is not what this campaign writes.
    pub fn read_block(&self, block: u64) -> Result<Option<Vec<Row>>, CampaignError> {
        let path = self.block_path(block);
        let text = match bounded::read_text(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            other => other.map_err(CampaignError::read(&path))?,
        };
        let bad = |reason: String| CampaignError::Block { path: path.clone(), reason };
        let parts = text.trim_end().strip_suffix("\"}").and_then(|text| text.rsplit_once(DIGEST));
        let Some((bytes, digest)) = parts else {
            return Err(bad("it has no digest at its end: damaged, or of another version".into()));
        };
        if sha256(bytes) != digest {
            return Err(bad("its digest is not that of its rows: edited, or damaged".into()));
        }
        let file: BlockFile =
            serde_json::from_str(&format!("{bytes}}}")).map_err(|error| bad(error.to_string()))?;
        if file.campaign != self.digest {
            return Err(bad("it belongs to another campaign".into()));
        }
        if !file.rows.iter().map(|row| row.drive.index).eq(self.drives_of(block)) {
            return Err(bad("its drives are not those of this block".into()));
        }
        if let Some(Row { drive, outcome }) = file.rows.iter().find(|row| !is_possible(row)) {
            return Err(bad(format!(
                "drive {}: monitored for {} s, {} s of them before a fault, in {} s",
                drive.index, outcome.monitored_s, outcome.monitored_fault_free_s, drive.duration_s
            )));
        }
        Ok(Some(file.rows))
    }

    /// The blocks among `blocks` that are not done.
    ///
    /// # Errors
    /// As [`Self::read_block`].
    pub fn missing(&self, blocks: Range<u64>) -> Result<Vec<u64>, CampaignError> {
        let mut missing = Vec::new();
        for block in blocks {
            if self.read_block(block)?.is_none() {
                missing.push(block);
            }
        }
        Ok(missing)
    }

    /// All rows in the order of their indices; `None` while blocks are missing.
    ///
    /// # Errors
    /// As [`Self::read_block`].
    pub fn rows(&self) -> Result<Option<Vec<Row>>, CampaignError> {
        let mut rows = Vec::new();
        for block in 0..self.blocks() {
            match self.read_block(block)? {
                Some(mut block) => rows.append(&mut block),
                None => return Ok(None),
            }
        }
        Ok(Some(rows))
    }

    /// Writes `results.parquet` and `report.json`.
    ///
    /// # Errors
    /// [`CampaignError`] if a file cannot be made or written.
    pub fn write_results(
        &self,
        rows: &[Row],
        report: &impl Serialize,
    ) -> Result<[PathBuf; 2], CampaignError> {
        let paths = ["results.parquet", "report.json"].map(|name| self.path.join(name));
        let [results, report_path] = &paths;
        output::write(results, &table::parquet(rows, self.manifest.clone())?)?;
        let text = serde_json::to_string_pretty(report)? + "\n";
        output::write(report_path, text.as_bytes())?;
        Ok(paths)
    }

    fn block_path(&self, block: u64) -> PathBuf {
        self.path.join("blocks").join(format!("{block:06}.json"))
    }
}

/// Whether times fit into the drive, whose last sample is at its end.
fn is_possible(Row { drive, outcome }: &Row) -> bool {
    let most_s = 1.1 * drive.duration_s;
    (0.0..=most_s).contains(&outcome.monitored_s)
        && (0.0..=outcome.monitored_s).contains(&outcome.monitored_fault_free_s)
}

/// Whether the text is that of no manifest at all.
fn is_damaged(manifest: &str) -> bool {
    !serde_json::from_str::<Map<String, Value>>(manifest).is_ok_and(|keys| !keys.is_empty())
}

/// The keys at which two manifests differ, with both values.
fn differences(there: &str, here: &str) -> String {
    let parse = |text| serde_json::from_str::<Map<String, Value>>(text).unwrap_or_default();
    let (there, here) = (parse(there), parse(here));
    let keys: BTreeSet<_> = there.keys().chain(here.keys()).collect();
    let show = |value: Option<&Value>| value.map_or("nothing".to_owned(), Value::to_string);
    let differing = keys.into_iter().filter(|key| there.get(*key) != here.get(*key));
    let lines = differing.map(|key| {
        format!("\n  {key}: {} there, {} now", show(there.get(key)), show(here.get(key)))
    });
    lines.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_manifest_without_a_campaign_is_damaged_and_another_one_another_campaign() {
        let here = serde_json::json!({"drives": 3});
        let opened = |text: &str| {
            let folder = tempfile::tempdir().unwrap();
            std::fs::write(folder.path().join("campaign.json"), text).unwrap();
            Folder::open(folder.path(), 3, &here)
        };
        for text in ["", "{}", "[1]", "{\"drives\": 3"] {
            assert!(matches!(opened(text), Err(CampaignError::Damaged { .. })), "{text}");
        }
        assert!(matches!(opened("{\"drives\": 4}"), Err(CampaignError::OtherCampaign { .. })));
    }
}
