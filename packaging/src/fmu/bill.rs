//! Bill of materials of an FMU: its libraries by their digests, and what they link, in CycloneDX 1.6.
//!
//! # Conventions
//! - Versions and digests of packages are those of `Cargo.lock`, which the libraries are built by.
//! - A library of the FMU is a component of type `file`, named by its path; its digest is that of the bytes in
//!   the FMU, design and all.
//! - Without serial number and time: the same for the same libraries.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::digest::sha256;

/// Path in an FMU.
pub const BILL: &str = "documentation/sbom.cdx.json";

/// What CycloneDX calls a file.
const FILE: &str = "file";

/// What CycloneDX calls SHA-256, the one digest in bills.
const SHA_256: &str = "SHA-256";

const LOCK: &str = include_str!("../../../Cargo.lock");

/// Packages of others that every library links, and their licences: `documentation/licenses` has the texts.
const OTHERS: [(&str, &str); 3] = [("crc", OURS), ("crc-catalog", OURS), ("libm", "MIT")];

/// Licence of what is ours.
const OURS: &str = "MIT OR Apache-2.0";

/// Of our packages, those of every library.
const COMMON: [&str; 3] =
    ["steerguard-detector", "steerguard-fmu-core", "steerguard-model-description"];

#[derive(Deserialize)]
struct Lock {
    package: Vec<Locked>,
}

#[derive(Deserialize)]
struct Locked {
    name: String,
    version: String,
    checksum: Option<String>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Bill<'a> {
    bom_format: &'a str,
    spec_version: &'a str,
    version: u32,
    metadata: Metadata<'a>,
    components: Vec<Component<'a>>,
    dependencies: [Dependency<'a>; 1],
}

#[derive(Serialize)]
struct Metadata<'a> {
    component: Component<'a>,
}

#[derive(Serialize)]
struct Component<'a> {
    r#type: &'a str,
    #[serde(rename = "bom-ref")]
    reference: String,
    name: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    version: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    description: Option<&'a str>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    hashes: Vec<Hash>,
    licenses: [License<'a>; 1],
    #[serde(skip_serializing_if = "Option::is_none")]
    purl: Option<String>,
}

#[derive(Serialize)]
struct Hash {
    alg: &'static str,
    content: String,
}

#[derive(Serialize)]
struct License<'a> {
    expression: &'a str,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Dependency<'a> {
    r#ref: &'a str,
    depends_on: Vec<&'a str>,
}

/// Digests of files by name, as the bill of some FMU, whoever made it, states them; none where it is no bill.
pub fn digests(bill: &[u8]) -> BTreeMap<String, String> {
    #[derive(Deserialize)]
    struct Bill {
        components: Vec<Component>,
    }
    #[derive(Deserialize)]
    struct Component {
        r#type: String,
        name: String,
        #[serde(default)]
        hashes: Vec<Hash>,
    }
    #[derive(Deserialize)]
    struct Hash {
        alg: String,
        content: String,
    }
    let components =
        serde_json::from_slice(bill).map_or_else(|_| Vec::new(), |bill: Bill| bill.components);
    let files = components.into_iter().filter(|component| component.r#type == FILE);
    files
        .filter_map(|Component { name, hashes, .. }| {
            let hash = hashes.into_iter().find(|hash| hash.alg == SHA_256)?;
            Some((name, hash.content))
        })
        .collect()
}

/// The bill of the model `name`, whose `libraries`, bytes by path, link `ours` beside what every library does.
///
/// # Errors
/// None that an FMU can cause.
pub fn bill(
    name: &str,
    ours: &[&str],
    libraries: &BTreeMap<String, Vec<u8>>,
) -> Result<String, BillError> {
    let lock: Lock = toml::from_str(LOCK)?;
    let mut linked: Vec<(&str, &str)> =
        COMMON.iter().chain(ours).map(|name| (*name, OURS)).chain(OTHERS).collect();
    linked.sort_unstable();
    let mut components = Vec::new();
    for (name, licence) in linked {
        let locked = lock.package.iter().find(|locked| locked.name == name);
        let locked = locked.ok_or_else(|| BillError::Missing(name.to_owned()))?;
        let hash = locked.checksum.clone().map(|content| Hash { alg: SHA_256, content });
        // What is ours is on no registry.
        let purl = hash.as_ref().map(|_| format!("pkg:cargo/{name}@{}", locked.version));
        components.push(Component {
            r#type: "library",
            reference: purl.clone().unwrap_or_else(|| format!("{name}@{}", locked.version)),
            name,
            version: Some(&locked.version),
            description: None,
            hashes: hash.into_iter().collect(),
            licenses: [License { expression: licence }],
            purl,
        });
    }
    components.push(Component {
        r#type: "library",
        reference: "core".to_owned(),
        name: "core",
        version: None,
        description: Some("Rust's core library, of the compiler that built the library"),
        hashes: Vec::new(),
        licenses: [License { expression: OURS }],
        purl: None,
    });
    let references: Vec<String> =
        components.iter().map(|component| component.reference.clone()).collect();
    components.extend(libraries.iter().map(|(path, library)| Component {
        r#type: FILE,
        reference: path.clone(),
        name: path,
        version: None,
        description: None,
        hashes: vec![Hash { alg: SHA_256, content: sha256(library) }],
        licenses: [License { expression: OURS }],
        purl: None,
    }));
    let bill = Bill {
        bom_format: "CycloneDX",
        spec_version: "1.6",
        version: 1,
        metadata: Metadata {
            component: Component {
                r#type: "library",
                reference: name.to_owned(),
                name,
                version: Some(env!("CARGO_PKG_VERSION")),
                description: None,
                hashes: Vec::new(),
                licenses: [License { expression: OURS }],
                purl: None,
            },
        },
        components,
        dependencies: [Dependency {
            r#ref: name,
            depends_on: references.iter().map(String::as_str).collect(),
        }],
    };
    Ok(serde_json::to_string_pretty(&bill)? + "\n")
}

/// A lock file that does not know what the library links: a mistake of this build.
#[derive(Debug, thiserror::Error)]
pub enum BillError {
    /// A package is not locked.
    #[error("Cargo.lock has no package `{0}`")]
    Missing(String),
    /// The lock file cannot be read.
    #[error("Cargo.lock: {0}")]
    Lock(#[from] toml::de::Error),
    /// The bill cannot be written.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
}
