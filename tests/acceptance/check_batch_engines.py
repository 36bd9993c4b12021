#!/usr/bin/env python3
"""scripts/parallel_sweep.sh and scripts/slurm_sweep.sh: the bytes of one run, also after tasks were killed.

    check_batch_engines.py --qerr build/qerr [--verbose]

Slurm runs here as one node on loopback with ports, folders and a munge of its own, which all end with the test. An engine
that is not installed is skipped (Slurm also where this does not run as root).
"""
import contextlib
import filecmp
import os
import pathlib
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

from tool import program_and_tally, run

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPTS, CONFIGS = ROOT / "scripts", ROOT / "configs"
SPEC = CONFIGS / "scara" / "spec.yaml"
FEW = ["--set", "configurations.count=300"]
SHORT = ["--set", "motion.duration=0.2"]  # of SPEC: its noise along the motion is most of the time of a variant
SHARDS = 5


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def torn(rng, source, target):
    """What a killed task leaves: the begin of a shard."""
    data = source.read_bytes()
    target.write_bytes(data[: rng.randrange(len(data))])


def descendants(process):
    """Processes that this one has started, and theirs."""
    parents = {}
    for entry in pathlib.Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            parents.setdefault(int((entry / "stat").read_text().rpartition(")")[2].split()[1]), []).append(int(entry.name))
    found = list(parents.get(process, []))
    for child in found:
        found += parents.get(child, [])
    return found


def check_sweep(t, qerr, name, script, environment, folder):
    one, merged = folder / f"{name}_one.csv", folder / f"{name}.csv"
    run(qerr, "sweep", "-q", SPEC, *FEW, *SHORT, "-o", one)
    shards = pathlib.Path(f"{merged}.shards")
    shards.mkdir()
    rng = random.Random(1)
    for k in (2, 3):  # killed tasks of an earlier call; another one is complete
        run(qerr, "sweep", "-q", SPEC, *FEW, *SHORT, "--shard", f"{k}/{SHARDS}", "-o", folder / "whole.csv")
        torn(rng, folder / "whole.csv", shards / f"{k}.csv")
    run(qerr, "sweep", "-q", SPEC, *FEW, *SHORT, "--shard", f"4/{SHARDS}", "-o", shards / "4.csv")
    done = subprocess.run([script, SPEC, str(SHARDS), merged, *FEW, *SHORT], env=environment, capture_output=True, text=True, timeout=300)
    same = done.returncode == 0 and filecmp.cmp(one, merged, shallow=False)
    t.check(f"{name}: {SHARDS} shards, two of them resumed, are the bytes of one run", same, done.stderr[-500:])
    t.check(f"{name}: the shards are removed", not shards.exists())


def check_specs(t, name, script, environment, folder):
    reports = folder / f"{name}_reports"
    specs = [SPEC, CONFIGS / "kuka_lwr" / "spec.yaml", CONFIGS / "planar_prr" / "spec.yaml"]

    def call(command, *more):
        words = [script, "--each", command, reports, *specs, "--", *FEW, *more]
        return subprocess.run(words, env=environment, capture_output=True, text=True, timeout=300)

    done = call("analyze", "--set", "requirements=[]")
    written = sorted(reports.glob("*.json"))
    t.check(f"{name}: analyze of each of {len(specs)} specs", done.returncode == 0 and len(written) == len(specs), done.stderr[-500:])
    stamps = [report.stat().st_mtime_ns for report in written]
    again = call("analyze", "--set", "requirements=[]")
    t.check(f"{name}: what is complete is kept", again.returncode == 0 and stamps == [r.stat().st_mtime_ns for r in written])
    shutil.rmtree(reports)
    hard = "requirements=[{quantity: position.x.worst_case, statistic: max, at_most: 1e-12}]"
    failed = call("check", "--set", hard)
    t.check(f"{name}: check ends with 1 where a requirement is not met", failed.returncode == 1, f"{failed.returncode} {failed.stderr[-500:]}")


def check_killed(t, qerr, script, environment, folder):
    """Every task is killed while it runs; the second call goes on."""
    spec = folder / "slow.yaml"
    spec.write_text(SPEC.read_text().replace("urdf: scara.urdf", f"urdf: {SPEC.parent / 'scara.urdf'}"))
    slow = ["--set", "configurations.count=200000", "--set", "motion.duration=1", "--set", "filters.velocity.lowpass.order=1"]
    merged, one = folder / "killed.csv", folder / "killed_one.csv"
    call = subprocess.Popen([script, spec, "2", merged, *slow], env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                            start_new_session=True)
    shards = pathlib.Path(f"{merged}.shards")
    for _ in range(500):
        if any(shards.glob("*.csv")) and max(s.stat().st_size for s in shards.glob("*.csv")) > 20000:
            break
        time.sleep(0.02)
    for process in [call.pid, *descendants(call.pid)]:
        with contextlib.suppress(ProcessLookupError):
            os.kill(process, signal.SIGKILL)
    call.wait()
    t.check("the tasks were killed before the merge", not merged.exists())
    done = subprocess.run([script, spec, "2", merged, *slow], env=environment, capture_output=True, text=True, timeout=300)
    run(qerr, "sweep", "-q", spec, *slow, "-o", one)
    same = done.returncode == 0 and filecmp.cmp(one, merged, shallow=False)
    t.check("the second call completes them to the bytes of one run", same, done.stderr[-500:])


SLURM_CONF = """ClusterName=qerr
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort={control}
SlurmdPort={node}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
MpiDefault=none
ReturnToService=2
SchedulerType=sched/builtin
SchedulerParameters=batch_sched_delay=0,sched_min_interval=0,sched_interval=1
NodeName=localhost NodeAddr=127.0.0.1 CPUs={cpus} State=UNKNOWN
PartitionName=local Nodes=localhost Default=YES State=UP
"""


@contextlib.contextmanager
def slurm(folder):
    """A cluster of this machine; yields the environment of its clients."""
    (folder / "state").mkdir()
    (folder / "spool").mkdir()
    folder.chmod(0o755)
    key = folder / "munge.key"
    key.write_bytes(os.urandom(128))
    key.chmod(0o400)
    conf = folder / "slurm.conf"
    conf.write_text(SLURM_CONF.format(folder=folder, control=free_port(), node=free_port(), cpus=os.cpu_count()))
    environment = {**os.environ, "SLURM_CONF": str(conf), "SLURM_POLL": "0.3"}
    quiet = dict(stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)
    started = []

    def start(*words):
        started.append(subprocess.Popen([str(w) for w in words], start_new_session=True, **quiet))

    try:
        start("munged", "--foreground", "--force", f"--key-file={key}", f"--socket={folder}/munge.socket", f"--pid-file={folder}/munged.pid",
              f"--log-file={folder}/munged.log", f"--seed-file={folder}/munged.seed")
        for _ in range(100):
            if (folder / "munge.socket").exists():
                break
            time.sleep(0.05)
        start("slurmctld", "-D", "-c")
        time.sleep(1)
        start("slurmd", "-D", "-N", "localhost")
        for _ in range(100):
            states = subprocess.run(["sinfo", "--noheader", "--format=%T"], env=environment, capture_output=True, text=True).stdout
            if states.strip() == "idle":
                break
            time.sleep(0.2)
        else:
            raise RuntimeError("Slurm does not start: " + (folder / "slurmctld.log").read_text()[-2000:])
        yield environment
    finally:
        for process in reversed(started):
            process.terminate()
        for process in started:
            try:
                process.wait(timeout=20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def main():
    qerr, t = program_and_tally()
    environment = {**os.environ, "QERR": str(qerr)}
    skipped = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        parallel = SCRIPTS / "parallel_sweep.sh"
        version = shutil.which("parallel") and subprocess.run(["parallel", "--version"], capture_output=True, text=True).stdout
        if version and "GNU parallel" in version:
            check_sweep(t, qerr, "parallel", parallel, environment, folder)
            check_specs(t, "parallel", parallel, environment, folder)
            check_killed(t, qerr, parallel, environment, folder)
        else:
            skipped.append("GNU parallel is not installed")
        lacking = [word for word in ("munged", "slurmctld", "slurmd", "sbatch") if not shutil.which(word, path=os.environ["PATH"] + ":/usr/sbin")]
        if lacking or os.geteuid() != 0:
            skipped.append(f"Slurm: {', '.join(lacking)} not installed" if lacking else "Slurm: only root can start it")
        else:
            cluster = folder / "slurm"
            cluster.mkdir()
            environment["PATH"] = os.environ["PATH"] = os.environ["PATH"] + ":/usr/sbin"
            with slurm(cluster) as more:
                environment = {**environment, **more}
                check_sweep(t, qerr, "slurm", SCRIPTS / "slurm_sweep.sh", environment, folder)
                check_specs(t, "slurm", SCRIPTS / "slurm_sweep.sh", environment, folder)
    for reason in skipped:
        print(f"skip  {reason}", file=sys.stderr)
    if len(skipped) == 2:
        return 0
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
