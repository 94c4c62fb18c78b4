//! Scripts that run the shards of a sweep on many machines: job arrays of schedulers that exist.
//!
//! Each shard appends to a file of its own beside the manifest and goes on where it stopped, so a
//! scheduler may run a task again whenever it likes.

use crate::error::SweepError;
use std::str::FromStr;

/// Most shards of a script: what schedulers take as one array. A choice.
pub const MOST_SHARDS: usize = 100_000;

/// What runs the shards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheduler {
    /// Slurm: a job array for `sbatch`.
    Slurm,
    /// HyperQueue: a task array of `hq submit`.
    Hq,
    /// Dask: a script in Python for a `distributed` cluster.
    Dask,
    /// Kubernetes: an indexed Job.
    Kubernetes,
}

impl Scheduler {
    /// All of them with their names.
    pub const ALL: [(&'static str, Scheduler); 4] = [
        ("slurm", Scheduler::Slurm),
        ("hq", Scheduler::Hq),
        ("dask", Scheduler::Dask),
        ("k8s", Scheduler::Kubernetes),
    ];
}

impl FromStr for Scheduler {
    type Err = String;

    fn from_str(name: &str) -> Result<Scheduler, String> {
        let found = Scheduler::ALL.iter().find(|(known, _)| *known == name);
        found.map(|(_, scheduler)| *scheduler).ok_or_else(|| {
            let known: Vec<&str> = Scheduler::ALL.iter().map(|(name, _)| *name).collect();
            format!(
                "there is no scheduler `{name}`; known: {}",
                known.join(", ")
            )
        })
    }
}

/// How a sweep is divided among machines.
#[derive(Clone, Debug)]
pub struct Job {
    /// The manifest as the machines see it.
    pub manifest: String,
    /// Number of shards.
    pub shards: usize,
    /// Cores that each is given.
    pub cores: usize,
    /// Container image, for Kubernetes.
    pub image: String,
}

/// Memory for each core, MB.
const CORE_MB: usize = 256;

/// What follows a shard in a script of a shell: a cell that cannot be run is a result, and its exit code 1
/// is no reason to run the shard again.
const ACCEPT: &str = "code=$?\n[ \"$code\" -le 1 ] || exit \"$code\"";

/// A text as one word of a shell.
fn quoted(text: &str) -> String {
    format!("'{}'", text.replace('\'', "'\\''"))
}

/// A text as a string of JSON, which is one of YAML and Python, too.
fn string(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// The script, at most 40 lines.
///
/// ```
/// use lostmotion_sweep::emit::{Job, Scheduler, script};
///
/// let job = Job { manifest: "gaps.jsonl".to_owned(), shards: 64, cores: 8, image: String::new() };
/// let text = script(Scheduler::Slurm, &job)?;
/// assert!(text.contains("#SBATCH --array=1-64") && text.lines().count() <= 40);
/// # Ok::<(), lostmotion_sweep::SweepError>(())
/// ```
///
/// # Errors
/// A number of shards or cores, or a name of the manifest, that cannot be used.
pub fn script(scheduler: Scheduler, job: &Job) -> Result<String, SweepError> {
    job.check()?;
    Ok(match scheduler {
        Scheduler::Slurm => job.slurm(),
        Scheduler::Hq => job.hq(),
        Scheduler::Dask => job.dask(),
        Scheduler::Kubernetes => job.kubernetes(),
    })
}

impl Job {
    /// Refuses what no scheduler takes.
    fn check(&self) -> Result<(), SweepError> {
        let Job { shards, cores, .. } = *self;
        if !(1..=MOST_SHARDS).contains(&shards) {
            let message = format!("{shards} shards; it has to be 1 to {MOST_SHARDS}");
            return Err(SweepError::value(message, "a shard is a task of the array"));
        }
        if !(1..=1024).contains(&cores) {
            let message = format!("{cores} cores for a shard; it has to be 1 to 1024");
            return Err(SweepError::value(message, ""));
        }
        if self.manifest.chars().any(char::is_control) {
            let message = format!(
                "the name {:?} of the manifest has control characters",
                self.manifest
            );
            return Err(SweepError::value(message, "rename it"));
        }
        Ok(())
    }

    fn slurm(&self) -> String {
        let Job { shards, cores, .. } = *self;
        let manifest = quoted(&self.manifest);
        format!(
            "#!/bin/bash
# Slurm: sbatch THIS_FILE; then: lostmotion study sweep collect {manifest} --out table.parquet
#SBATCH --job-name=lostmotion-sweep
#SBATCH --array=1-{shards}
#SBATCH --cpus-per-task={cores}
#SBATCH --mem-per-cpu={CORE_MB}M
#SBATCH --requeue
set -u
lostmotion --quiet study sweep run {manifest} --shard \"$SLURM_ARRAY_TASK_ID/{shards}\" --threads {cores}
{ACCEPT}
"
        )
    }

    fn hq(&self) -> String {
        let Job { shards, cores, .. } = *self;
        let manifest = quoted(&self.manifest);
        format!(
            "#!/bin/bash
# HyperQueue: start a server (hq server start) and workers, then run this file; tasks are run again
# when a worker is lost. Then: lostmotion study sweep collect {manifest} --out table.parquet
set -eu
hq submit --wait --name lostmotion-sweep --array 1-{shards} --cpus {cores} --crash-limit 20 \\
    --stdout none --stderr none -- bash -c '
lostmotion --quiet study sweep run \"$1\" --shard \"$HQ_TASK_ID/{shards}\" --threads {cores}
{ACCEPT}
' lostmotion {manifest}
"
        )
    }

    fn dask(&self) -> String {
        let Job { shards, cores, .. } = *self;
        let (manifest, name) = (quoted(&self.manifest), string(&self.manifest));
        format!(
            "# Dask: python THIS_FILE tcp://SCHEDULER:8786, in the folder of the manifest, which workers share.
# A worker runs a shard for each of its threads: --nthreads of its cores divided by {cores}.
# Then: lostmotion study sweep collect {manifest} --out table.parquet
import os
import subprocess
import sys

from dask.distributed import Client, as_completed

MANIFEST = {name}
SHARDS = {shards}


def shard(index: int, folder: str) -> int:
    command = [\"lostmotion\", \"--quiet\", \"study\", \"sweep\", \"run\", MANIFEST]
    command += [\"--shard\", f\"{{index}}/{{SHARDS}}\", \"--threads\", \"{cores}\"]
    run = subprocess.run(command, cwd=folder, stderr=subprocess.PIPE, text=True)
    if run.returncode not in (0, 1):  # 1: cells that cannot be run, which are results
        raise RuntimeError(f\"shard {{index}}: exit code {{run.returncode}}: {{run.stderr}}\")
    return run.returncode


if __name__ == \"__main__\":
    client = Client(sys.argv[1])
    tasks = client.map(shard, range(1, SHARDS + 1), folder=os.getcwd(), retries=3, pure=False)
    for done, task in enumerate(as_completed(tasks), 1):
        task.result()
        print(f\"{{done}} of {{SHARDS}} shards\")
"
        )
    }

    fn kubernetes(&self) -> String {
        let Job { shards, cores, .. } = *self;
        let (image, name) = (string(&self.image), string(&self.manifest));
        let memory_mb = CORE_MB * cores;
        format!(
            "# Kubernetes: kubectl apply -f THIS_FILE. The claim `sweep` holds the folder of the manifest,
# and all that it names: ReadWriteMany where nodes share it. The image has the program lostmotion.
# Kubernetes 1.29 or newer (backoffLimitPerIndex).
apiVersion: batch/v1
kind: Job
metadata:
  name: lostmotion-sweep
spec:
  completionMode: Indexed
  completions: {shards}
  parallelism: {shards}
  backoffLimitPerIndex: 20
  template:
    spec:
      restartPolicy: Never
      containers:
        - name: shard
          image: {image}
          workingDir: /sweep
          command:
            - sh
            - -c
            - |
              lostmotion --quiet study sweep run \"$MANIFEST\" --shard \"$((JOB_COMPLETION_INDEX + 1))/{shards}\" --threads {cores}
              code=$?; [ \"$code\" -le 1 ] || exit \"$code\"
          env:
            - name: MANIFEST
              value: {name}
          resources:
            requests: {{ cpu: {cores}, memory: {memory_mb}Mi }}
          volumeMounts:
            - {{ name: sweep, mountPath: /sweep }}
      volumes:
        - name: sweep
          persistentVolumeClaim: {{ claimName: sweep }}
"
        )
    }
}
