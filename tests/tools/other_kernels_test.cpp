// The program on other kernels, in containers and on file systems that lack something: it goes on,
// and says what it could not have, or it refuses before the work. Each row names a report about
// another program.
#include <fcntl.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <string>
#include <vector>

#include "plait/mesh_io.h"
#include "support/other_kernel.h"
#include "support/sanitized.h"
#include "support/skip.h"
#include "support/test_meshes.h"
#include "support/usable_backends.h"
#include "workplace.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;
using Catch::Matchers::Contains;

constexpr int kNotSupportedByKernel = 524;

struct KernelPlace : Workplace {
  std::string expected;
  explicit KernelPlace(const std::string& backend = "pread") {
    write_ply(path("mesh.ply"), random_sheet(5, 60));
    plait({"subdivide", "mesh.ply", "s.plait", "--levels", "3", "--backend", backend});
    expected = digest("s.plait");
  }
};

struct OtherKernel {
  std::string report;
  std::vector<Answer> answers;
  std::string said;  ///< by each command that misses it; nothing if nobody needs to know
};

/// Commands that together make, replace, copy, join, read and export stores.
void check_commands(const KernelPlace& here, const std::string& said) {
  const std::vector<Words> commands = {
      {"subdivide", "mesh.ply", "s.plait", "--levels", "3", "--force"},
      {"convert", "s.plait", "c.plait", "--compress", "small", "--force"},
      {"plan", "mesh.ply", "p.plan", "--levels", "3", "--parts", "2"},
      {"part", "p.plan", "0"},
      {"part", "p.plan", "1"},
      {"join", "p.plan", "j.plait"},
      {"bounds", "c.plait"},
      {"export", "c.plait", "out.ply", "--force"},
      {"verify", "j.plait"}};
  bool was_said = said.empty();
  for (const Words& command : commands) {
    const Outcome outcome = here.plait(command);
    CAPTURE(command, outcome.errors);
    CHECK(outcome.status == 0);
    if (said.empty())
      CHECK(outcome.errors.empty());
    else if (!outcome.errors.empty())
      CHECK_THAT(outcome.errors, Contains(said));
    was_said = was_said || !outcome.errors.empty();
  }
  CHECK(was_said);
  for (const char* store : {"s.plait", "c.plait", "j.plait"})
    CHECK(here.plait({"digest", store}).last_line() == here.expected);
}

}  // namespace

TEST_CASE("Commands_OnKernelsThatAnswerOtherwise_MakeTheSameStores") {
  const std::vector<OtherKernel> kernels = {
      // Locks that a file system does not have.
      {"h5py/h5py#1082: NFS without a lock service", {{SYS_flock, ENOLCK}}, "has no locks"},
      {"HDFGroup/hdf5#3311: DVS", {{SYS_flock, kNotSupportedByKernel}}, "has no locks"},
      {"SmileiPIC/Smilei#342: Lustre without flock", {{SYS_flock, ENOSYS}}, "has no locks"},
      {"the same by a filter", {{SYS_flock, EPERM}}, "has no locks"},
      {"a file system that takes no operation of flock", {{SYS_flock, EINVAL}}, "has no locks"},
      {"one that takes only writers", {{SYS_flock, EBADF}}, "has no locks"},
      // Words that cannot be exchanged, or not be kept from replacing others.
      {"google/gvisor#7895", {{SYS_renameat2, EINVAL, 4, 2}}, "cannot exchange two names"},
      {"oven-sh/bun#36229: NFS, any flag", {{SYS_renameat2, EINVAL}}, "cannot exchange two names"},
      {"rust-lang/libs-team#131: no such call", {{SYS_renameat2, ENOSYS}}, "cannot exchange"},
      {"libseccomp before 2.2 with the default EPERM", {{SYS_renameat2, EPERM}}, "cannot exchange"},
      // Calls that are only faster, or that containers and other kernels do not know.
      {"transmission/transmission#3756", {{SYS_linkat, EXDEV}, {SYS_copy_file_range, EXDEV}}, ""},
      {"NixOS/nix#3749: BeeGFS", {{SYS_linkat, EPERM}, {SYS_copy_file_range, EOPNOTSUPP}}, ""},
      {"rfjakob/gocryptfs#22: ZFS", {{SYS_fallocate, EOPNOTSUPP}}, ""},
      {"cockroachdb/cockroach#37752: WSL", {{SYS_sync_file_range, ENOSYS}}, ""},
      {"the same by a filter",
       {{SYS_sync_file_range, EPERM}, {SYS_fallocate, EPERM}, {SYS_fadvise64, EPERM}},
       ""},
      {"signals that never end", {{SYS_fallocate, EINTR}}, ""},
      {"no free space is told", {{SYS_statfs, ENOSYS}}, ""},
      {"libuv/libuv#2724: Docker before 18.04", {{SYS_statx, EPERM}}, ""},
      {"kontainapp/km#1746: advice", {{SYS_madvise, EINVAL}}, ""}};
  bool is_mapped = false;
  int number = 0;
  for (const OtherKernel& kernel : kernels) {
    is_mapped = !is_mapped;
    if (number++ % unless_sanitized(1, 3) != 0) continue;
    CAPTURE(kernel.report, is_mapped);
    const KernelPlace here(is_mapped ? "mmap" : "pread");
    if (!on_other_kernel(kernel.answers, [&] { check_commands(here, kernel.said); }))
      return skip("the system allows no filter of system calls");
    CHECK(here.names() == Words{"c.plait", "j.plait", "mesh.ply", "out.ply", "p.plan", "s.plait"});
  }
}

// A store that was made by io_uring, where there is none: the files are those of pread.
TEST_CASE("StoreOfUring_WhereTheKernelRefusesARing_IsReadByPreadAndTheLimitIsNamed") {
  if (std::ranges::count(usable_backends(), "uring") == 0) return skip("no io_uring here");
  const std::vector<OtherKernel> kernels = {
      {"moby/moby#39396", {{SYS_io_uring_setup, EPERM}}, "kernel.io_uring_disabled"},
      {"podman-container-tools/podman#16796", {{SYS_io_uring_setup, ENOSYS}}, "filter of system"},
      {"axboe/liburing#93", {{SYS_io_uring_setup, ENOMEM}}, "RLIMIT_MEMLOCK"},
      {"axboe/liburing#1088", {{SYS_io_uring_setup, EMFILE}}, "RLIMIT_NOFILE"},
      {"a ring that may be made and not be used",
       {{SYS_io_uring_enter, EPERM}},
       "filter of system"},
      {"the same, of another filter", {{SYS_io_uring_enter, ENOSYS}}, "filter of system"}};
  const KernelPlace here("uring");
  for (const OtherKernel& kernel : kernels) {
    CAPTURE(kernel.report);
    const Words before = here.names();
    if (!on_other_kernel(kernel.answers, [&] {
          for (const Words& command :
               {Words{"digest", "s.plait"},
                {"verify", "s.plait"},
                {"export", "s.plait", "a.ply"},
                {"subdivide", "mesh.ply", "u.plait", "--levels", "1", "--backend", "uring"}}) {
            const Outcome outcome = here.plait(command);
            CAPTURE(command, outcome.errors);
            CHECK(outcome.status == 0);
            CHECK_THAT(outcome.errors, Contains(kernel.said) && Contains("pread instead"));
            if (command[0] == "digest") CHECK(outcome.last_line() == here.expected);
          }
          for (const char* made : {"a.ply", "u.plait"})
            fs::remove_all(here.directory.path() / made);
        }))
      return skip("the system allows no filter of system calls");
    CHECK(here.names() == before);
  }
}

// mattermost/mattermost#19123, containerd/cri#862: a limit of processes. glibc takes clone() where
// there is no clone3(), whose flags a filter cannot see.
TEST_CASE("Commands_WhereNoThreadCanBeHad_FailInWordsAndLeaveNothing") {
  const KernelPlace here;
  const Words before = here.names();
  const std::vector<Answer> no_threads = {{SYS_clone3, ENOSYS},
                                          {SYS_clone, EAGAIN, 0, CLONE_THREAD}};
  if (!on_other_kernel(no_threads, [&] {
        for (const Words& command :
             {Words{"subdivide", "mesh.ply", "n.plait", "--levels", "4", "--threads", "4"},
              {"convert", "s.plait", "n.plait", "--threads", "4"},
              {"import", "mesh.ply", "n.plait", "--threads", "4"},
              {"digest", "s.plait", "--threads", "4"}}) {
          const Outcome outcome = here.plait(command);
          CAPTURE(command, outcome.errors, outcome.output);
          CHECK((outcome.status == 0 || outcome.status == 1 || outcome.status == 2));
          CHECK(outcome.error_lines() <= 1);
          if (outcome.status == 1) CHECK_THAT(outcome.errors, Contains("thread"));
          if (here.has("n.plait")) CHECK(here.plait({"clean", "."}).status == 0);
        }
      }))
    return skip("the system allows no filter of system calls");
  CHECK(here.names() == before);
}

// moby/moby#25409, conda/conda#6711, rust-lang/rustup#1239: what comes with the image of a
// container is in a lower layer, whose directories cannot be renamed.
TEST_CASE("Force_OverAStoreInALowerLayer_IsRefusedBeforeTheWork") {
  const KernelPlace here;
  const fs::path all = here.directory.path();
  for (const char* name : {"upper", "work", "merged", "lower"}) fs::create_directory(all / name);
  fs::rename(all / "s.plait", all / "lower" / "s.plait");
  fs::copy(all / "mesh.ply", all / "lower" / "mesh.ply");
  std::ofstream(all / "lower" / "out.ply") << "old";
  const auto mount = [&] {
    const std::string options = "lowerdir=" + (all / "lower").native() +
                                ",upperdir=" + (all / "upper").native() +
                                ",workdir=" + (all / "work").native();
    return ::mount("overlay", (all / "merged").c_str(), "overlay", 0, options.c_str()) == 0;
  };
  const auto work = [&] {
    const auto plait = [&](Words arguments) { return run(all / "merged", std::move(arguments)); };
    for (const Words& command :
         {Words{"subdivide", "mesh.ply", "s.plait", "--levels", "2", "--force"},
          {"convert", "s.plait", "n.plait"},
          {"convert", "n.plait", "s.plait", "--force"}}) {
      const Outcome outcome = plait(command);
      CAPTURE(command, outcome.errors);
      if (command.back() != "--force") {
        CHECK(outcome.status == 0);
        continue;
      }
      CHECK(outcome.status != 0);
      CHECK_THAT(outcome.errors, Contains("replace s.plait") && Contains("lower layer") &&
                                     Contains("Invalid cross-device link"));
    }
    CHECK(plait({"digest", "s.plait"}).last_line() == here.expected);
    // What is made here can be replaced, and so can files of a lower layer.
    CHECK(plait({"subdivide", "mesh.ply", "n.plait", "--levels", "3", "--force"}).status == 0);
    CHECK(plait({"digest", "n.plait"}).last_line() == here.expected);
    CHECK(plait({"export", "n.plait", "out.ply", "--force"}).status == 0);
    CHECK(plait({"bounds", "s.plait"}).status == 0);  // a commit into the store of the lower layer
    CHECK(plait({"verify", "s.plait"}).status == 0);
    CHECK(names_in(all / "merged") == Words{"mesh.ply", "n.plait", "out.ply", "s.plait"});
  };
  if (!with_own_mounts(mount, work)) return skip("no overlay can be mounted here");
}

// metno/hdf5-rust#175, paradigmxyz/reth#6354, kriszyp/lmdb-js#271: a volume that is mounted for
// reading only.
TEST_CASE("StoreOnAReadOnlyMount_IsReadByEveryCommandAndRefusedToWriters") {
  for (const std::string& backend : usable_backends()) {
    if (backend == "memory") continue;
    CAPTURE(backend);
    const KernelPlace here(backend);
    const fs::path all = here.directory.path();
    const auto mount = [&] {
      return ::mount(all.c_str(), all.c_str(), nullptr, MS_BIND, nullptr) == 0 &&
             ::mount(nullptr, all.c_str(), nullptr, MS_REMOUNT | MS_BIND | MS_RDONLY, nullptr) == 0;
    };
    const auto work = [&] {
      const Outcome digest = here.plait({"digest", "s.plait"});
      CHECK(digest.last_line() == here.expected);
      CHECK(digest.errors.empty());
      CHECK(here.plait({"verify", "s.plait"}).status == 0);
      CHECK(here.plait({"info", "s.plait"}).status == 0);
      for (const Words& command : {Words{"bounds", "s.plait"},
                                   {"export", "s.plait", "a.ply"},
                                   {"convert", "s.plait", "s.plait", "--force"},
                                   {"repair", "s.plait"}}) {
        const Outcome outcome = here.plait(command);
        CAPTURE(command, outcome.errors);
        if (command[0] == "repair" && outcome.status == 0) continue;  // nothing was damaged
        CHECK(outcome.status != 0);
        CHECK(outcome.error_lines() == 1);
      }
    };
    if (!with_own_mounts(mount, work)) return skip("nothing can be mounted here");
    CHECK(here.names() == Words{"mesh.ply", "s.plait"});
  }
}

// rust-lang/rust#83904, uutils/coreutils#11122: what cannot be printed is no success.
TEST_CASE("Commands_WithClosedStreams_MakeTheSameStoreAndLoseNoWord") {
  const KernelPlace here;
  const auto closed = [&](const std::string& streams, const Words& arguments) {
    std::string line = std::string("exec ") + PLAIT_PROGRAM;
    for (const std::string& word : arguments) line += " " + word;
    const std::string whole = "cd " + here.directory.path().native() + " && " + line + streams;
    const int status = std::system(whole.c_str());  // NOLINT(cert-env33-c,concurrency-mt-unsafe)
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  };
  // Each of the three may be the first descriptor that is free.
  for (const std::string streams : {" <&- >/dev/null", " 2>&- >/dev/null", " <&- 2>&- >/dev/null"})
    for (const std::string& backend : usable_backends()) {
      if (backend == "memory") continue;
      CAPTURE(streams, backend);
      CHECK(closed(streams, {"subdivide", "mesh.ply", "n.plait", "--levels", "3", "--force",
                             "--backend", backend}) == 0);
      CHECK(here.plait({"digest", "n.plait"}).last_line() == here.expected);
      CHECK(here.plait({"verify", "n.plait"}).status == 0);
    }
  for (const std::string streams : {" >&-", " >&- 2>&-", " <&- >&- 2>&-", " >/dev/full"}) {
    CAPTURE(streams);
    CHECK(closed(streams + (streams.find("2>") == std::string::npos ? " 2>/dev/null" : ""),
                 {"digest", "s.plait"}) == 1);
    CHECK(closed(streams + (streams.find("2>") == std::string::npos ? " 2>/dev/null" : ""),
                 {"info", "s.plait", "--json"}) == 1);
  }
  CHECK(here.plait({"digest", "s.plait"}).last_line() == here.expected);
}

}  // namespace plait::test
