//! `steerguard schema`: what `--json` prints, as JSON Schemas.
//!
//! # Conventions
//! - Schemas are those of the types that are printed, described by the types' own documentation.
//! - They forbid no further keys: later versions may print more.

use clap::ValueEnum as _;
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use schemars::{JsonSchema, Schema};
use serde_json::Value;

use super::print::write;
use super::{
    campaign, check, design, failure, identify, init, main_job, package, report, simulate, verify,
    worst,
};
use crate::campaign::table::Row;
use crate::cli::arguments::{Printed, SchemaArguments};
use crate::cli::failure::{Exit, Failure};
use crate::drive::scenario::Scenario;
use crate::replay::report::Summary;

pub(super) fn run(arguments: &SchemaArguments) -> Result<Exit, Failure> {
    let schema = titled(arguments.printed);
    write(&(serde_json::to_string_pretty(&schema).map_err(Failure::bad)? + "\n"))?;
    Ok(Exit::Done)
}

/// The schema of what is `printed`, with what prints it as title.
fn titled(printed: Printed) -> Schema {
    let mut schema = schema(printed);
    let title = printed.to_possible_value().and_then(|value| value.get_help().cloned());
    schema.insert("title".into(), title.unwrap_or_default().to_string().into());
    schema
}

fn schema(printed: Printed) -> Schema {
    match printed {
        Printed::MainJob => of::<main_job::Demonstration>(),
        Printed::Init => of::<init::Begun<'_>>(),
        Printed::Identify => of::<identify::Report>(),
        Printed::Design => of::<design::Designed<'_>>(),
        Printed::Verify => of::<verify::Verified>(),
        Printed::Package => of::<package::PackagedDesign>(),
        Printed::Check => of::<check::Checked<'_>>(),
        Printed::Simulate => of::<simulate::Simulated>(),
        Printed::Scenario => of::<Scenario>(),
        Printed::Campaign => of::<campaign::DrivenPart>(),
        Printed::CampaignDrive => of::<Row>(),
        Printed::CampaignSignals => of::<campaign::Signals<'_>>(),
        Printed::CampaignWorst => of::<worst::Report>(),
        Printed::Replay => of::<Summary>(),
        Printed::Report => of::<report::Reported<'_>>(),
        Printed::Failure => of::<failure::Record<'_>>(),
    }
}

fn of<T: JsonSchema>() -> Schema {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let settings = settings.with_transform(RecursiveTransform(open_and_readable));
    settings.into_generator().into_root_schema_for::<T>()
}

/// In the words of JSON, without Rust's links, which lead nowhere here, and open to keys that a later version adds.
fn open_and_readable(schema: &mut Schema) {
    if let Some(Value::String(text)) = schema.get_mut("description") {
        *text = text.replace("[`", "`").replace("`]", "`").replace("`None`", "null");
    }
    if schema.get("additionalProperties") == Some(&Value::Bool(false)) {
        schema.remove("additionalProperties");
    }
}
