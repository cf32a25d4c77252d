"""`steerguard campaign` on the workers of a Dask cluster.

Conventions
- The `steerguard` command does everything that the results depend on; this package carries design
  and blocks between machines. So the results have the same bytes as those of one machine.
- A worker needs Dask and the `steerguard` command, of the build that the main process has: what
  `campaign.json` says of the FMUs must be the same.
- A shard is a part of the campaign as in `steerguard campaign --shard K/N`; blocks are its files.
"""
