// Reads meshes in a child process with limited address space. Large counts in a header must cost no
// memory, and a real mesh must need only a few times the size of its file.

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>

#include "mesh_files.h"
#include "shapes.h"
#include "support/skip.h"

using namespace plait;
using namespace plait::mesh_files;

namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kCanLimit = false;  // shadow memory needs address space too
#else
constexpr bool kCanLimit = true;
#endif

constexpr int kMesh = 0, kOther = 100;

/// Reads a mesh in a child process that may allocate `more_bytes` more of address space. Returns
/// kMesh, 1 + the error's code, or kOther.
int read_within(const std::filesystem::path& path, std::uint64_t more_bytes) {
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    std::uint64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const rlim_t limit = pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) + more_bytes;
    const rlimit limits = {limit, limit};
    if (::setrlimit(RLIMIT_AS, &limits) != 0) ::_exit(kOther);
    try {
      read_base_mesh(path);
      ::_exit(kMesh);
    } catch (const Error& error) {
      ::_exit(1 + static_cast<int>(error.code()));
    } catch (...) {
      ::_exit(kOther);
    }
  }
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : kOther;
}

constexpr int kRefused = 1 + static_cast<int>(ErrorCode::kInvalidArgument);
constexpr const char* kCannotLimit = "address space cannot be limited under this sanitizer";
constexpr std::uint64_t kMebibyte = std::uint64_t{1} << 20;

}  // namespace

TEST_CASE("ReadBaseMesh_HeaderPromisesMillions_CostsNoMemory") {
  if (!kCanLimit) {
    test::skip(kCannotLimit);
    return;
  }
  const MeshDirectory directory;
  const std::string vertices =
      " 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string faces = "element face 1000000000\nproperty list uint int vertex_indices\n";
  const std::string few(1200, '\0');
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"})
    for (const bool faces_first : {false, true}) {
      INFO(format);
      const std::string header = std::string("ply\nformat ") + format;
      const std::string bytes =
          faces_first ? header + " 1.0\n" + faces + vertices.substr(5) : header + vertices + faces;
      const std::string whole = bytes + "end_header\n" + few;
      CHECK(read_within(directory.file("a.ply", whole), 16 * kMebibyte) == kRefused);
      CHECK(read_within(directory.file("a.ply.gz", gzip(whole)), 16 * kMebibyte) == kRefused);
      CHECK(read_within(directory.file("a.ply.zst", zstd(whole)), 16 * kMebibyte) == kRefused);
    }
  const std::string list =
      "ply\nformat binary_little_endian 1.0\nelement junk 4000000000\nproperty list uint double "
      "values\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uint int vertex_indices\nend_header\n";
  CHECK(read_within(directory.file("b.ply", list + "\xff\xff\xff\xff" + few), 16 * kMebibyte) ==
        kRefused);
  CHECK(read_within(directory.file("c.off", "OFF\n4000000000 1000000000 0\n0 0 0\n"),
                    16 * kMebibyte) == kRefused);
  CHECK(read_within(directory.file("d.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4000000000 0 1 2\n"),
                    16 * kMebibyte) == kRefused);
}

TEST_CASE("ReadBaseMesh_TooLittleMemory_IsAnErrorOfItsOwn") {
  if (!kCanLimit) {
    test::skip(kCannotLimit);
    return;
  }
  const MeshDirectory directory;
  const auto path = directory.file("a.ply", ply_binary(shapes::torus(1000, 1000), false));
  CHECK(read_within(path, 8 * kMebibyte) == 1 + static_cast<int>(ErrorCode::kOutOfMemory));
}

TEST_CASE("ReadBaseMesh_MillionFaces_NeedFewTimesTheFile") {
  if (!kCanLimit) {
    test::skip(kCannotLimit);
    return;
  }
  const MeshDirectory directory;
  const auto path = directory.file("a.ply", ply_binary(shapes::torus(700, 800), false));
  CHECK(read_within(path, 5 * std::filesystem::file_size(path)) == kMesh);
}
