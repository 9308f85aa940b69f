// A mesh that is laid out in files has the same bytes as one that was laid out in memory, with any
// memory for its sorts; what memory refuses, files refuse with the same words; and stores copy it.
#include "plait/layout.h"

#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "format/base_index_file.h"
#include "format/base_mesh_file.h"
#include "format/file_names.h"
#include "layout/base_directory.h"
#include "layout/external_sort.h"
#include "layout/lay_out_in_files.h"
#include "plait/extend/parts.h"
#include "plait/job.h"
#include "plait/mesh_io.h"
#include "plait/registry.h"
#include "plait/subdivision_job.h"
#include "support/error_of.h"
#include "support/file_bytes.h"
#include "support/sanitized.h"
#include "support/shuffled_mesh.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

enum class Form : std::uint8_t { kAscii, kLittleEndian, kBigEndian };

/// Positions as double, faces as list uint8 int32.
void write_mesh(const std::filesystem::path& path, const IndexedMesh& mesh, Form form) {
  std::ofstream file(path, std::ios::binary);
  file.precision(17);
  file << "ply\nformat "
       << (form == Form::kAscii          ? "ascii"
           : form == Form::kLittleEndian ? "binary_little_endian"
                                         : "binary_big_endian")
       << " 1.0\nelement vertex " << mesh.positions.size()
       << "\nproperty double x\nproperty double y\nproperty double z\nelement face "
       << mesh.faces.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
  const auto put = [&](auto number) {
    std::array<char, sizeof(number)> bytes;
    std::memcpy(bytes.data(), &number, sizeof(number));
    if (form == Form::kBigEndian) std::reverse(bytes.begin(), bytes.end());
    file.write(bytes.data(), bytes.size());
  };
  for (const Vector3<double>& p : mesh.positions) {
    if (form == Form::kAscii) {
      file << p.x << ' ' << p.y << ' ' << p.z << '\n';
      continue;
    }
    for (const double x : {p.x, p.y, p.z}) put(x);
  }
  for (const std::array<VertexId, 3>& face : mesh.faces) {
    if (form == Form::kAscii) {
      file << "3 " << face[0] << ' ' << face[1] << ' ' << face[2] << '\n';
      continue;
    }
    put(char{3});
    for (const VertexId vertex : face) put(vertex);
  }
}

/// What both ways say and write.
struct Result {
  std::string mesh, index;
  std::vector<std::string> warnings;
  std::uint64_t merged_runs = 0;
};

Result in_memory(const std::filesystem::path& path) {
  const TemporaryDirectory made(Medium::kMemory);
  const Directory directory(made.path());
  Result result;
  const BaseMesh mesh = lay_out(read_base_mesh(path, &result.warnings), LayoutKind::kHilbert).mesh;
  const StoredSize size = write_base_mesh_file(directory, mesh);
  write_base_index_file(directory, kBaseIndexName, mesh, size.checksum, false);
  result.mesh = content_of(made.path() / kBaseMeshName);
  result.index = content_of(made.path() / kBaseIndexName);
  return result;
}

Result in_files(const std::filesystem::path& path, SortMemory memory) {
  const TemporaryDirectory made(Medium::kMemory);
  const Directory directory(made.path());
  const FileLayoutResult laid_out = lay_out_in_files({path, memory}, directory);
  CHECK(directory.names() == std::vector<std::string>{kBaseIndexName, kBaseMeshName});
  Result result{content_of(made.path() / kBaseMeshName), content_of(made.path() / kBaseIndexName),
                laid_out.warnings, laid_out.merged_runs};
  CHECK(laid_out.base_mesh.bytes == result.mesh.size());
  return result;
}

void check_same(const IndexedMesh& mesh, Form form, SortMemory memory) {
  const TemporaryDirectory files(Medium::kMemory);
  const std::filesystem::path path = files.path() / "m.ply";
  write_mesh(path, mesh, form);
  const Result expected = in_memory(path), found = in_files(path, memory);
  CHECK((found.mesh == expected.mesh));
  CHECK((found.index == expected.index));
  CHECK(found.warnings == expected.warnings);
}

/// The mesh among vertices that no face uses.
IndexedMesh with_unused_vertices(IndexedMesh mesh, unsigned seed) {
  std::mt19937 random(seed);
  IndexedMesh result;
  std::vector<VertexId> number;
  for (const Vector3<double>& p : mesh.positions) {
    for (; random() % 3 == 0;) result.positions.push_back({1e6, double(random() % 100), 0});
    number.push_back(static_cast<VertexId>(result.positions.size()));
    result.positions.push_back(p);
  }
  result.positions.push_back({-7, -7, -7});
  for (std::array<VertexId, 3> face : mesh.faces) {
    for (VertexId& vertex : face) vertex = number[vertex];
    result.faces.push_back(face);
  }
  return result;
}

constexpr SortMemory kMuch{std::uint64_t{64} << 20}, kLittle{std::uint64_t{1} << 14, 2048},
    kHardlyAny{2000, 64};

}  // namespace

TEST_CASE("Laying out in files gives the bytes of laying out in memory") {
  SECTION("small meshes of all kinds") {
    unsigned turn = 0;
    for (const NamedMesh& named : all_meshes()) {
      INFO(named.name);
      const SortMemory memory = turn % 3 == 0 ? kMuch : turn % 3 == 1 ? kLittle : kHardlyAny;
      check_same(named.mesh, static_cast<Form>(turn++ / 3 % 3), memory);
    }
  }
  SECTION("random meshes") {
    for (unsigned seed = 0; seed < unless_sanitized(40u, 15u); ++seed) {
      CAPTURE(seed);
      IndexedMesh mesh = side_by_side({random_sphere(seed, 40 + seed), random_sheet(seed, 90),
                                       single_triangle(), random_torus(seed, 30), open_fan(30)});
      mesh = shuffled(mesh, seed);
      if (seed % 2 == 0) mesh = with_unused_vertices(mesh, seed);
      if (seed % 5 == 0)
        for (Vector3<double>& p : mesh.positions) p = {std::floor(p.x), 0, -0.0};  // equal keys
      check_same(mesh, Form::kLittleEndian, seed % 3 == 0 ? kLittle : kHardlyAny);
    }
  }
  SECTION("more than a window of the compressor, and many merges of many runs") {
    const TemporaryDirectory files;
    const std::filesystem::path path = files.path() / "m.ply";
    // As many runs of a quarter of the faces under a sanitizer, which finds no more in longer ones.
    const std::uint32_t part = unless_sanitized(2u, 4u);
    write_mesh(
        path,
        shuffled(side_by_side({torus_grid(500 / part, 400 / part), sheet(300 / part, 300 / part)}),
                 5),
        Form::kLittleEndian);
    const Result expected = in_memory(path);
    const std::uint64_t share = std::uint64_t{part} * part;
    for (const SortMemory memory :
         {SortMemory{(1u << 20) / share, (1u << 17) / share}, SortMemory{(12u << 20) / share}}) {
      const Result found = in_files(path, memory);
      CHECK((found.mesh == expected.mesh));
      CHECK((found.index == expected.index));
      CHECK(found.merged_runs > 20);
    }
  }
  SECTION("a mesh that has the order already") {
    const IndexedMesh mesh = shuffled(torus_grid(30, 20), 3);
    const BaseMesh ordered = lay_out(BaseMesh::build(mesh), LayoutKind::kHilbert).mesh;
    check_same({{ordered.positions().begin(), ordered.positions().end()},
                {ordered.faces().begin(), ordered.faces().end()}},
               Form::kAscii, kLittle);
  }
}

TEST_CASE("Laying out in files refuses what memory refuses, with the same words") {
  const TemporaryDirectory files(Medium::kMemory);
  const std::filesystem::path path = files.path() / "m.ply";
  const auto check_same_error = [&](ErrorCode code) {
    const Error expected = error_of([&] { (void)read_base_mesh(path); });
    CHECK(expected.code() == code);
    for (const SortMemory memory : {kMuch, kHardlyAny}) {
      const TemporaryDirectory made(Medium::kMemory);
      const Directory directory(made.path());
      const Error found = error_of([&] { (void)lay_out_in_files({path, memory}, directory); });
      CHECK(found.code() == code);
      CHECK(std::string(found.what()) == expected.what());
    }
  };
  IndexedMesh mesh = shuffled(side_by_side({torus_grid(8, 7), sheet(5, 4)}), 9);
  SECTION("two fans at a vertex") {
    const auto far = static_cast<VertexId>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), {{9, 9, 9}, {9, 8, 9}});
    mesh.faces.push_back({mesh.faces[3][0], far, far + 1});
    write_mesh(path, mesh, Form::kLittleEndian);
    check_same_error(ErrorCode::kInvalidArgument);
  }
  SECTION("three faces and four at an edge") {
    const auto far = static_cast<VertexId>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), {{9, 9, 9}, {9, 8, 9}});
    mesh.faces.push_back({mesh.faces[7][0], mesh.faces[7][1], far});
    if (GENERATE(false, true)) mesh.faces.push_back({mesh.faces[7][1], mesh.faces[7][0], far + 1});
    write_mesh(path, mesh, Form::kLittleEndian);
    check_same_error(ErrorCode::kInvalidArgument);
  }
  SECTION("a face and its copy") {
    write_mesh(path, {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {1, 2, 0}}},
               Form::kLittleEndian);
    check_same_error(ErrorCode::kInvalidArgument);
  }
  SECTION("a vertex twice in a face") {
    mesh.faces[5][1] = mesh.faces[5][0];
    mesh.faces[9][1] = mesh.faces[9][2];
    write_mesh(path, mesh, Form::kBigEndian);
    check_same_error(ErrorCode::kInvalidArgument);
  }
  SECTION("a vertex that is not there, before and behind a vertex twice in a face") {
    mesh.faces[5][1] = mesh.faces[5][0];
    mesh.faces[GENERATE(4u, 6u)][1] = 100000;
    write_mesh(path, mesh, GENERATE(Form::kAscii, Form::kLittleEndian));
    check_same_error(ErrorCode::kInvalidArgument);
  }
  SECTION("not finite") {
    mesh.positions[4].y = std::numeric_limits<double>::infinity();
    write_mesh(path, mesh, Form::kLittleEndian);
    check_same_error(ErrorCode::kInvalidArgument);
  }
  SECTION("cut short, at each byte from vertices to the end") {
    write_mesh(path, sheet(1, 1), Form::kLittleEndian);
    const std::string whole = content_of(path);
    for (std::size_t bytes = whole.size() - 60; bytes < whole.size(); ++bytes) {
      std::ofstream(path, std::ios::binary | std::ios::trunc) << whole.substr(0, bytes);
      check_same_error(ErrorCode::kInvalidArgument);
    }
  }
  SECTION("no faces, and no file") {
    write_mesh(path, {{{0, 0, 0}}, {}}, Form::kAscii);
    check_same_error(ErrorCode::kInvalidArgument);
    std::filesystem::remove(path);
    check_same_error(ErrorCode::kNotFound);
  }
}

TEST_CASE("Laying out in files says what only memory can take") {
  const TemporaryDirectory files(Medium::kMemory);
  const TemporaryDirectory made(Medium::kMemory);
  const Directory directory(made.path());
  const auto refusal = [&](const std::filesystem::path& path) {
    const Error error = error_of([&] { (void)lay_out_in_files({path, kMuch}, directory); });
    CHECK(error.code() == ErrorCode::kNotSupported);
    return std::string(error.what());
  };
  const std::filesystem::path path = files.path() / "m.ply";
  SECTION("faces of two orientations") {
    IndexedMesh mesh = torus_grid(5, 5);
    std::swap(mesh.faces[20][1], mesh.faces[20][2]);
    write_mesh(path, mesh, Form::kLittleEndian);
    CHECK_THAT(refusal(path), Catch::Matchers::Contains("to have one orientation"));
  }
  SECTION("polygons") {
    std::ofstream(path) << "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty "
                           "float y\nproperty float z\nelement face 1\nproperty list uchar int "
                           "vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
    CHECK_THAT(refusal(path), Catch::Matchers::Contains("4 corners"));
  }
  SECTION("other formats") {
    std::ofstream(files.path() / "m.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    CHECK_THAT(refusal(files.path() / "m.obj"), Catch::Matchers::Contains("expected a PLY file"));
  }
}

TEST_CASE("A vertex with more faces than the memory holds is refused") {
  const TemporaryDirectory files(Medium::kMemory);
  const std::filesystem::path path = files.path() / "m.ply";
  write_mesh(path, bipyramid(70000), Form::kLittleEndian);
  const Directory directory(files.path());
  CHECK(code_of([&] {
          (void)lay_out_in_files({path, {1u << 18, 4096}}, directory);
        }) == ErrorCode::kBudget);
  CHECK_NOTHROW((void)lay_out_in_files({path, kMuch}, directory));
}

TEST_CASE("A disk that is too small is refused before the mesh is read") {
  const TemporaryDirectory files(Medium::kMemory);
  const std::filesystem::path path = files.path() / "m.ply";
  // The header alone: whoever reads on finds the end.
  std::ofstream(path) << "ply\nformat binary_little_endian 1.0\nelement vertex 4294967294\n"
                         "property float x\nproperty float y\nproperty float z\n"
                         "element face 1073741824\n"
                         "property list uchar int vertex_indices\nend_header\n";
  const bool fits = std::filesystem::space(files.path()).available >
                    disk_need(4294967294, 1073741824, {std::uint64_t{2} << 30});
  const Error error = error_of([&] {
    (void)run_job("layout", {{"mesh", path.native()}, {"out", (files.path() / "m.base").native()}});
  });
  CHECK(error.code() == (fits ? ErrorCode::kInvalidArgument : ErrorCode::kNoSpace));
  CHECK(Directory(files.path()).names() == std::vector<std::string>{"m.ply"});
}

TEST_CASE("Less memory than the program itself takes is refused") {
  const TemporaryDirectory files(Medium::kMemory);
  const std::filesystem::path path = files.path() / "m.ply";
  write_mesh(path, single_triangle(), Form::kAscii);
  const JobOptions options = {
      {"mesh", path.native()}, {"out", (files.path() / "m.base").native()}, {"memory", "95MiB"}};
  CHECK(code_of([&] { (void)run_job("layout", options); }) == ErrorCode::kBudget);
  CHECK(Directory(files.path()).names() == std::vector<std::string>{"m.ply"});
}

TEST_CASE("Each progress can cancel the layout, and nothing stays") {
  const TemporaryDirectory files(Medium::kMemory);
  const std::filesystem::path path = files.path() / "m.ply";
  write_mesh(path, torus_grid(80, 80), Form::kLittleEndian);
  const JobOptions options = {
      {"mesh", path.native()}, {"out", (files.path() / "m.base").native()}, {"memory", "100M"}};
  std::vector<std::uint64_t> told;
  std::vector<std::string> phases;
  JobWatch watch;
  watch.progress = [&](const Progress& now) {
    CHECK(now.done <= now.total);
    told.push_back(now.done);
    if (phases.empty() || phases.back() != now.phase) phases.emplace_back(now.phase);
    return true;
  };
  (void)run_job("layout", options, watch);
  CHECK(std::ranges::is_sorted(told));
  CHECK(phases.size() == 12);
  std::filesystem::remove_all(files.path() / "m.base");
  for (std::size_t last = 0; last < told.size(); ++last) {
    std::size_t calls = 0;
    watch.progress = [&](const Progress&) { return calls++ < last; };
    CHECK(code_of([&] { (void)run_job("layout", options, watch); }) == ErrorCode::kCancelled);
    CHECK(Directory(files.path()).names() == std::vector<std::string>{"m.ply"});
  }
}

TEST_CASE("A store of a mesh in files has the bytes of one of the file") {
  const TemporaryDirectory files(Medium::kMemory);
  const std::filesystem::path path = files.path() / "m.ply", base = files.path() / "m.base";
  write_mesh(path, with_unused_vertices(shuffled(torus_grid(120, 80), 2), 4), Form::kLittleEndian);
  (void)run_job("layout", {{"mesh", path.native()}, {"out", base.native()}, {"memory", "96MiB"}});
  const auto subdivide = [&](const std::filesystem::path& mesh, const std::string& name,
                             std::optional<std::uint64_t> max_slot_bytes,
                             std::optional<LayoutKind> layout) {
    const SubdivisionRequest request{.mesh = mesh,
                                     .store = files.path() / name,
                                     .levels = 2,
                                     .layout = layout,
                                     .max_slot_bytes = max_slot_bytes,
                                     .digest = true};
    return SubdivisionJob(request, default_backends()).run().digest;
  };
  SECTION("copied") {
    CHECK(subdivide(path, "a.plait", {}, LayoutKind::kHilbert) ==
          subdivide(base, "b.plait", {}, {}));
    CHECK(
        (content_of(base / kBaseMeshName) == content_of(files.path() / "a.plait" / kBaseMeshName)));
  }
  SECTION("refined in memory") {
    CHECK(subdivide(path, "a.plait", 12, LayoutKind::kHilbert) ==
          subdivide(base, "b.plait", 12, LayoutKind::kHilbert));
  }
  SECTION("in another order") {
    CHECK(subdivide(path, "a.plait", {}, LayoutKind::kRcm) ==
          subdivide(base, "b.plait", {}, LayoutKind::kRcm));
  }
  for (const char* const name : {kBaseMeshName, kBaseIndexName})
    CHECK((content_of(files.path() / "a.plait" / name) ==
           content_of(files.path() / "b.plait" / name)));
}

TEST_CASE("A plan takes a mesh in files") {
  const TemporaryDirectory files(Medium::kMemory);
  const std::filesystem::path path = files.path() / "m.ply", base = files.path() / "m.base";
  write_mesh(path, shuffled(torus_grid(120, 80), 2), Form::kLittleEndian);
  (void)run_job("layout", {{"mesh", path.native()}, {"out", base.native()}});
  for (const auto& [mesh, plan] : {std::pair{path, "a.plan"}, std::pair{base, "b.plan"}})
    (void)run_job("plan", {{"input", mesh.native()},
                           {"plan", (files.path() / plan).native()},
                           {"levels", "2"},
                           {"parts", "3"}});
  for (const char* const name : {kBaseMeshName, kBaseIndexName})
    CHECK(
        (content_of(files.path() / "a.plan" / name) == content_of(files.path() / "b.plan" / name)));
}

TEST_CASE("Damage of a mesh in files is found before it is in a store") {
  const TemporaryDirectory files(Medium::kMemory);
  const std::filesystem::path path = files.path() / "m.ply", base = files.path() / "m.base";
  write_mesh(path, torus_grid(40, 40), Form::kLittleEndian);
  (void)run_job("layout", {{"mesh", path.native()}, {"out", base.native()}});
  const auto subdivide = [&] {
    (void)run_job("subdivide", {{"input", base.native()},
                                {"output", (files.path() / "s.plait").native()},
                                {"levels", "1"}});
  };
  const std::filesystem::path damaged =
      base /
      GENERATE(std::string(kBaseMeshName), std::string(kBaseIndexName), std::string("layout"));
  std::string bytes = content_of(damaged);
  if (GENERATE(true, false))
    bytes[bytes.size() / 2] ^= 1;
  else
    bytes.pop_back();
  std::ofstream(damaged, std::ios::binary | std::ios::trunc) << bytes;
  const Error error = error_of(subdivide);
  CHECK(error.code() == ErrorCode::kCorruption);
  CHECK_FALSE(std::filesystem::exists(files.path() / "s.plait"));
}

TEST_CASE("Records come out of an external sort in order, however many runs there are") {
  const TemporaryDirectory files(Medium::kMemory);
  const Directory directory(files.path());
  std::mt19937_64 random(1);
  for (const SortMemory memory :
       {SortMemory{16, 8}, SortMemory{64, 16}, SortMemory{800, 32}, SortMemory{1 << 20}})
    for (const std::size_t count : {0u, 1u, 2u, 3u, 7u, 8u, 9u, 63u, 64u, 65u, 1000u}) {
      CAPTURE(memory.bytes, count);
      ExternalSort<std::uint64_t> sort(directory, memory);
      std::vector<std::uint64_t> expected, found;
      for (std::size_t at = 0; at < count; ++at) {
        expected.push_back(random() % (count / 2 + 1));
        sort.push(expected.back());
      }
      std::ranges::sort(expected);
      sort.sort();
      for (std::uint64_t record; sort.next(record);) found.push_back(record);
      CHECK(found == expected);
      CHECK(directory.names().empty());
    }
}

}  // namespace plait::test
