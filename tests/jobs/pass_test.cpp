// Passes over a store in shards, in parts: the same records, digests and bytes as one process makes
// over a store in one piece; what is stale, foreign, forged or damaged is refused in words.
#include "plait/extend/pass.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "conversion/conversion_job.h"
#include "displace/displace.h"
#include "engine/store/format_reader.h"
#include "format/checksum.h"
#include "io/file_operations.h"
#include "plait/compression.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/check_store.h"
#include "plait/extend/parts.h"
#include "plait/mesh_io.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/subdivision_job.h"
#include "support/error_of.h"
#include "support/sanitized.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test::passes {
namespace {

namespace fs = std::filesystem;
using Numbers = std::vector<std::uint32_t>;
using Point = Vector3<float>;

/// Stores of one surface, in one piece and in shards.
struct Surfaces {
  fs::path mesh, directory;
  int levels = 3;
  bool normals = false;
  ComponentType precision = ComponentType::kFloat32;
  std::optional<std::uint64_t> max_slot_bytes = 100;  // refines the base mesh in memory
  PipelinesOf pipeline_of = {};

  fs::path whole() const { return directory / "whole.plait"; }
  fs::path sharded() const { return directory / "s.plait"; }

  void make_whole() const {
    SubdivisionRequest request;
    request.mesh = mesh;
    request.store = whole();
    request.levels = levels;
    request.normals = normals;
    request.precision = precision;
    request.max_slot_bytes = max_slot_bytes;
    request.block_bytes = 4 << 10;
    request.backend = "pread";
    request.layout = LayoutKind::kHilbert;
    SubdivisionJob(request, default_backends()).run();
  }
  void make_shards(std::uint32_t parts) const {
    PartsRequest request;
    request.mesh = mesh;
    request.plan = directory / "shards";
    request.parts = parts;
    request.levels = levels;
    request.normals = normals;
    request.precision = precision;
    request.max_slot_bytes = max_slot_bytes;
    request.block_bytes = 4 << 10;
    request.pipeline_of = pipeline_of;
    plan_parts(request, default_backends());
    for (std::uint32_t part = 0; part < parts; ++part)
      make_part(request.plan, part, {}, default_backends());
    REQUIRE(join_parts(request.plan, sharded(), {}, default_backends()).has_store);
    fs::remove_all(request.plan);
  }
  fs::path plan(const Pass& pass, const std::string& name = "plan") const {
    PassRequest request;
    request.store = sharded();
    request.plan = directory / name;
    request.pass = pass;
    plan_pass(request, default_backends());
    return request.plan;
  }
};

Surfaces surfaces_of(const fs::path& directory, const IndexedMesh& mesh) {
  Surfaces made;
  made.directory = directory;
  made.mesh = directory / "mesh.ply";
  write_ply(made.mesh, mesh);
  return made;
}

void make_parts(const fs::path& plan, const Pass& pass = {}, int threads = 1) {
  PartOptions options;
  options.threads = threads;
  options.kernel = pass.kernel;
  // The last part first: no part needs another one.
  for (auto part = static_cast<std::uint32_t>(read_parts_plan(plan).parts.size()); part-- > 0;)
    make_part(plan, part, options, default_backends());
}

JoinResult join(const fs::path& plan, const fs::path& store, const JoinOptions& options = {}) {
  return join_parts(plan, store, options, default_backends());
}

/// One pass in parts.
void pass_in_parts(const Surfaces& on, const Pass& pass, int threads = 1) {
  const fs::path plan = on.plan(pass, "one.pass");
  make_parts(plan, pass, threads);
  JoinOptions options;
  options.verify = true;
  REQUIRE(join(plan, on.sharded(), options).has_store);
  fs::remove_all(plan);
}

std::string digest_of(const fs::path& store) {
  return digest(Store::open(store, {}, default_backends())).to_string();
}

Store open_to_write(const fs::path& store) {
  OpenOptions options;
  options.writable = true;
  return Store::open(store, options, default_backends());
}

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// The files of a copy in one piece that say nothing of its UUID.
std::map<std::string, std::string> converted(const fs::path& from) {
  const fs::path to = from.native() + ".copy";
  ConversionRequest request;
  request.from = from;
  request.to = to;
  convert(request, default_backends(), default_backends(), {});
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(to))
    if (const std::string name = entry.path().filename();
        name.starts_with("attribute") || name == "base.mesh")
      files[name] = bytes_of(entry.path());
  fs::remove_all(to);
  return files;
}

/// A program's own smoothing, as simple as it can be: each vertex becomes the mean of its
/// neighbours' and its own position, on borders of those on the border.
void smooth_simply(Store& store, double factor) {
  store.add_attribute(schema_of<Point>("smoother"), store.finest_level());
  visit_vertices(store, {.name = "smooth"},
                 std::tuple{rings_of<Point>("position"), overwrites<Point>("smoother")},
                 [&](const VertexRun& run, const VertexRings<Point>& ring, std::span<Point> to) {
                   for (std::size_t i = 0; i < run.count; ++i) {
                     std::array<double, 3> sum{};
                     int count = 0;
                     for (int k = 0; k < ring.valence(); ++k) {
                       if (ring.is_border() && k != 0 && k != ring.valence() - 1) continue;
                       ++count;
                       const Point& at = ring.neighbour(i, k);
                       sum[0] += double{at.x};
                       sum[1] += double{at.y};
                       sum[2] += double{at.z};
                     }
                     const auto moved = [&](double from, double total) {
                       return static_cast<float>(from + factor * (1.0 / count * total - from));
                     };
                     const Point& from = ring.vertex(i);
                     to[i] = {moved(double{from.x}, sum[0]), moved(double{from.y}, sum[1]),
                              moved(double{from.z}, sum[2])};
                   }
                 });
  store.replace_attribute(store.attribute("position"), store.attribute("smoother"));
}

constexpr int kIterations = 5;
const Pass kSmooth{.name = "smooth", .factor = 0.4};

/// The digest and the files of one process's five iterations.
struct Expected {
  std::string digest;
  std::map<std::string, std::string> files;
};
Expected smoothed_by_one(const Surfaces& on, int iterations = kIterations) {
  on.make_whole();
  {
    Store store = open_to_write(on.whole());
    for (int pass = 0; pass < iterations; ++pass) smooth_simply(store, kSmooth.factor);
    store.commit();
  }
  return {digest_of(on.whole()), converted(on.whole())};
}

void check_smoothing(const Surfaces& on, const Expected& expected, std::uint32_t parts,
                     int iterations = kIterations) {
  CAPTURE(parts);
  on.make_shards(parts);
  for (int pass = 0; pass < iterations; ++pass) pass_in_parts(on, kSmooth, pass % 2 + 1);
  CHECK(digest_of(on.sharded()) == expected.digest);
  CHECK(converted(on.sharded()) == expected.files);
  const StoreCheck check = check_store(on.sharded(), default_backends());
  CHECK(check.damaged.empty());
  CHECK(check.left_over.empty());
  // A reader that was written from docs/format.md alone finds the same.
  const format::Store shards = format::read_store(on.sharded()),
                      one = format::read_store(on.whole());
  REQUIRE(shards.attributes.size() == one.attributes.size());
  for (std::size_t at = 0; at < one.attributes.size(); ++at) {
    CHECK(shards.attributes[at].levels == one.attributes[at].levels);
    CHECK(shards.attributes[at].base == one.attributes[at].base);
  }
  fs::remove_all(on.sharded());
}

/// Something that no pass of the library makes: it needs the number of a vertex, a ring, and an
/// attribute beside the positions.
Pass own_pass() {
  Pass pass;
  pass.name = "relief";
  pass.result = schema_of<float>("relief");
  pass.parameters = "weight 2";
  pass.kernel = [](Store& store, const std::string& into, const VisitOptions& options) {
    visit_vertices(
        store, options,
        std::tuple{rings_of<Point>("position"), reads<Point>("normal"), overwrites<float>(into)},
        [](const VertexRun& run, const VertexRings<Point>& ring, std::span<const Point> normal,
           std::span<float> to) {
          for (std::size_t i = 0; i < run.count; ++i)
            to[i] = 2 * dot(ring.neighbour(i, 0) - ring.vertex(i), normal[i]) +
                    static_cast<float>((run.first + i) % 1000) + static_cast<float>(run.point(i).i);
        });
  };
  return pass;
}

Error part_error(const fs::path& plan, std::uint32_t part) {
  PartOptions again;
  again.again = true;
  return error_of([&] { make_part(plan, part, again, default_backends()); });
}

fs::path directory_of(const fs::path& plan, std::uint32_t part) {
  for (const auto& entry : fs::directory_iterator(plan))
    if (entry.path().filename().native().starts_with("part." + std::to_string(part) + "-"))
      return entry.path();
  FAIL("part " << part << " has no directory");
  return {};
}

void write(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

/// Gives a file of a plan with other bytes the right checksum.
std::string sealed(std::string bytes) {
  const std::size_t end = bytes.size() - sizeof(std::uint64_t);
  const std::uint64_t checksum = checksum_of(std::as_bytes(std::span(bytes)).first(end));
  std::memcpy(bytes.data() + end, &checksum, sizeof checksum);
  return bytes;
}

/// Collects the paths that file operations change.
class ChangedPaths final : public FileOperationHook {
 public:
  ChangedPaths() { set_file_operation_hook(this); }
  ~ChangedPaths() { set_file_operation_hook(nullptr); }
  Verdict before(const FileOperation& operation) noexcept override {
    if (is_harmless(operation.kind)) return {};
    const std::scoped_lock lock(mutex_);
    paths.insert(operation.path);
    if (operation.to != nullptr) paths.insert(*operation.to);
    return {};
  }
  void after(const FileOperation&) noexcept override {}

  std::set<fs::path> paths;

 private:
  std::mutex mutex_;
};

}  // namespace

TEST_CASE("PassInParts_FiveIterationsOfSmoothing_GiveTheRecordsOfOneProcess") {
  const TemporaryDirectory here(Medium::kMemory);
  SECTION("a mesh with border, refined in memory first") {
    const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
    const Expected expected = smoothed_by_one(on);
    for (const std::uint32_t parts : {1u, 2u, 3u, 7u, 16u, 64u})
      check_smoothing(on, expected, parts);
  }
  SECTION("a closed mesh with slots of its own base mesh") {
    Surfaces on = surfaces_of(here.path(), random_sphere(3, 80));
    on.max_slot_bytes = std::nullopt;
    const Expected expected = smoothed_by_one(on);
    for (const std::uint32_t parts : {2u, 16u}) check_smoothing(on, expected, parts);
  }
  SECTION("a thousand parts, one iteration") {
    Surfaces on = surfaces_of(here.path(), random_sheet(9, 900));
    on.levels = 2;
    on.max_slot_bytes = std::nullopt;
    check_smoothing(on, smoothed_by_one(on, 1), unless_sanitized(1000u, 100u), 1);
  }
}

TEST_CASE("PassInParts_OnCompressedShards_GivesTheRecordsOfOneProcess") {
  const TemporaryDirectory here(Medium::kMemory);
  Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.pipeline_of = [](const AttributeSchema& schema) {
    return LevelPipelines(preset_pipeline("fast", schema));
  };
  const Expected expected = smoothed_by_one(on);
  on.make_shards(7);
  for (int pass = 0; pass < kIterations; ++pass) pass_in_parts(on, kSmooth);
  CHECK(digest_of(on.sharded()) == expected.digest);
}

TEST_CASE("PassInParts_Noise_MovesVerticesAsDisplaceDoes") {
  const TemporaryDirectory here(Medium::kMemory);
  Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  for (const ComponentType precision : {ComponentType::kFloat32, ComponentType::kFloat64}) {
    on.precision = precision;
    on.make_whole();
    Displaced displaced;
    {
      Store store = open_to_write(on.whole());
      displaced = displace(store, {.amplitude = 1e-3, .seed = 7});
      store.commit();
    }
    on.make_shards(7);
    const Pass noise{.name = "noise", .amplitude = 1e-3, .seed = 7};
    const fs::path plan = on.plan(noise);
    CHECK(read_parts_plan(plan).pass->pass.diagonal == displaced.diagonal);
    make_parts(plan);
    REQUIRE(join(plan, on.sharded()).has_store);
    CHECK(digest_of(on.sharded()) == digest_of(on.whole()));
    const Store store = Store::open(on.sharded(), {}, default_backends());
    CHECK(store.sequence() == 2);
    CHECK(store.provenance().scheme.empty());
    for (const char* const made : {"plan", "s.plait", "whole.plait"})
      fs::remove_all(here.path() / made);
  }
}

TEST_CASE("PassInParts_Normals_AreThoseOfSubdivision") {
  const TemporaryDirectory here(Medium::kMemory);
  Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  for (const std::uint32_t parts : {1u, 7u}) {
    on.normals = false;
    on.make_shards(parts);
    pass_in_parts(on, {.name = "normals"}, 2);
    on.normals = true;
    on.make_whole();
    CHECK(digest_of(on.sharded()) == digest_of(on.whole()));
    CHECK(converted(on.sharded()) == converted(on.whole()));
    // Again: now they replace normals.
    pass_in_parts(on, {.name = "normals"});
    CHECK(digest_of(on.sharded()) == digest_of(on.whole()));
    fs::remove_all(on.sharded());
    fs::remove_all(on.whole());
  }
}

TEST_CASE("PassInParts_OfTheProgramsOwn_GivesTheRecordsOfOneProcess") {
  const TemporaryDirectory here(Medium::kMemory);
  Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.normals = true;
  on.make_whole();
  {
    Store store = open_to_write(on.whole());
    run_pass(store, own_pass());
    store.commit();
  }
  on.make_shards(5);
  const fs::path plan = on.plan(own_pass());
  const PartsPlan known = read_parts_plan(plan);
  REQUIRE(known.pass);
  CHECK(known.pass->pass.parameters == "weight 2");
  CHECK(known.pass->result == schema_of<float>("relief"));
  CHECK(error_of([&] { make_parts(plan); }).code() == ErrorCode::kInvalidArgument);
  make_parts(plan, own_pass(), 2);
  REQUIRE(join(plan, on.sharded()).has_store);
  CHECK(digest_of(on.sharded()) == digest_of(on.whole()));
  CHECK(converted(on.sharded()) == converted(on.whole()));
}

TEST_CASE("PassInParts_KernelThatReadsNoRingsOrThrows_IsAnotherProgramsMatter") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sphere(3, 80));
  on.make_shards(3);
  Pass pass;
  pass.name = "height";
  pass.result = schema_of<float>("height");
  std::uint64_t base_runs = 0, base_vertices = 0;
  pass.kernel = [&](Store& store, const std::string& into, const VisitOptions& options) {
    visit_vertices(store, options, std::tuple{reads<Point>("position"), overwrites<float>(into)},
                   [&](const VertexRun& run, std::span<const Point> at, std::span<float> to) {
                     if (run.is_base()) ++base_runs, base_vertices += run.count;
                     for (std::size_t i = 0; i < run.count; ++i) to[i] = at[i].z;
                   });
  };
  const fs::path plan = on.plan(pass);
  make_parts(plan, pass);
  const Store before = Store::open(on.sharded(), {}, default_backends());
  CHECK(base_vertices == before.base().vertex_count());
  CHECK(base_runs < base_vertices);
  Pass failing = pass;
  failing.kernel = [](Store&, const std::string&, const VisitOptions&) {
    throw Error(ErrorCode::kCancelled, "stopped by the kernel");
  };
  PartOptions options;
  options.again = true;
  options.kernel = failing.kernel;
  CHECK_THAT(error_of([&] { make_part(plan, 1, options, default_backends()); }).what(),
             Catch::Contains("stopped by the kernel"));
  REQUIRE(join(plan, on.sharded()).has_store);  // what was done before stays done
  const Store after = Store::open(on.sharded(), {}, default_backends());
  const auto heights = after.base_records<float>(after.attribute("height"));
  const auto positions = after.base_records<Point>(after.attribute("position"));
  for (std::size_t vertex = 0; vertex < heights.size(); ++vertex)
    CHECK(heights[vertex] == positions[vertex].z);
}

TEST_CASE("PassJoin_ReadersOfTheVersionBefore_KeepIt") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.make_shards(4);
  const std::string first = digest_of(on.sharded());
  {
    const Store reader = Store::open(on.sharded(), {}, default_backends());
    pass_in_parts(on, kSmooth);
    CHECK(digest(reader).to_string() == first);
    CHECK(digest_of(on.sharded()) != first);
  }
  pass_in_parts(on, kSmooth);
  for (const auto& entry : fs::directory_iterator(on.sharded()))
    CHECK_FALSE(entry.path().filename().native().starts_with("attribute0.level"));
}

TEST_CASE("PassPart_MadeByFourAtOnce_IsMadeOnce") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.make_shards(2);
  const fs::path plan = on.plan(kSmooth);
  {
    std::array<std::jthread, 4> racing;
    for (std::jthread& one : racing)
      one = std::jthread([&] { make_part(plan, 1, {}, default_backends()); });
  }
  CHECK(make_part(plan, 1, {}, default_backends()).was_done);
  make_part(plan, 0, {}, default_backends());
  CHECK(join(plan, on.sharded()).has_store);
  std::size_t directories = 0;
  for (const auto& entry : fs::directory_iterator(plan)) directories += entry.is_directory();
  CHECK(directories == 2);
}

TEST_CASE("PassPart_ItsFiles_AreTheOnlyOnesItChanges") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.make_shards(3);
  const fs::path plan = on.plan(kSmooth);
  make_part(plan, 0, {}, default_backends());
  std::set<fs::path> paths;
  {
    ChangedPaths changed;
    make_part(plan, 1, {}, default_backends());
    paths = changed.paths;
  }
  REQUIRE_FALSE(paths.empty());
  for (const fs::path& path : paths) {
    CAPTURE(path);
    const std::string name = path.lexically_relative(plan).native();
    CHECK((name.starts_with("part.1-") || name == "done.1" || name == "."));  // it syncs "."
  }
}

TEST_CASE("PassPlan_ThatDoesNotFit_IsRefusedAndLeavesNothing") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.make_shards(3);
  on.make_whole();
  const auto refused = [&](const fs::path& store, const Pass& pass) {
    PassRequest request;
    request.store = store;
    request.plan = here.path() / "refused";
    request.pass = pass;
    const Error error = error_of([&] { plan_pass(request, default_backends()); });
    CHECK_FALSE(fs::exists(request.plan));
    return error;
  };
  CHECK(refused(on.whole(), kSmooth).code() == ErrorCode::kNotSupported);
  CHECK_THAT(refused(on.whole(), kSmooth).what(), Catch::Contains("in one piece"));
  CHECK(refused(here.path() / "none", kSmooth).code() == ErrorCode::kNotFound);
  for (const Pass& pass :
       {Pass{.name = "polish"}, Pass{.factor = 1.5}, Pass{.factor = -1},
        Pass{.name = "noise", .amplitude = 2}, Pass{.name = "noise", .diagonal = -1},
        Pass{.name = "own", .result = schema_of<double>("position")},
        Pass{.name = "a b", .result = schema_of<float>("x")},
        Pass{.name = "own", .result = schema_of<float>("x y")}}) {
    CAPTURE(pass.name, pass.result.name);
    CHECK(refused(on.sharded(), pass).code() == ErrorCode::kInvalidArgument);
  }
  const fs::path plan = on.plan(kSmooth);
  PassRequest again;
  again.store = on.sharded();
  again.plan = plan;
  CHECK(error_of([&] { plan_pass(again, default_backends()); }).code() ==
        ErrorCode::kInvalidArgument);
}

TEST_CASE("PassJoin_PartsMissingWrongOrStale_NamesThemByNumber") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  constexpr std::uint32_t kParts = 6;
  on.make_shards(kParts);
  const std::string before = digest_of(on.sharded());
  const fs::path plan = on.plan(kSmooth);
  const auto wrong = [&](const JoinOptions& options = {}) {
    const JoinResult joined = join(plan, on.sharded(), options);
    CHECK_FALSE(joined.has_store);
    CHECK(digest_of(on.sharded()) == before);
    return joined;
  };
  for (const std::uint32_t part : {0u, 2u}) make_part(plan, part, {}, default_backends());
  CHECK(wrong().again() == "1,3-5");
  make_parts(plan);
  SECTION("files are cut or missing") {
    const fs::path level = directory_of(plan, 3) / "attribute1.level03.2.shard3";
    fs::resize_file(level, fs::file_size(level) - 1);
    fs::remove(directory_of(plan, 4) / "version.2.shard4");
    fs::resize_file(plan / "done.5", fs::file_size(plan / "done.5") - 1);
    fs::remove(plan / "done.0");
    const JoinResult joined = wrong();
    CHECK(joined.bad == Numbers{3, 4, 5});
    CHECK(joined.again() == "0,3-5");
    make_parts(plan);
    CHECK(join(plan, on.sharded()).has_store);
  }
  SECTION("two parts are exchanged") {
    fs::rename(plan / "done.1", plan / "x");
    fs::rename(plan / "done.2", plan / "done.1");
    fs::rename(plan / "x", plan / "done.2");
    const JoinResult joined = wrong();
    CHECK(joined.bad == Numbers{1, 2});
    CHECK_THAT(joined.reasons.at(0), Catch::Contains("expected part 1, found part 2"));
  }
  SECTION("a part is of another plan of the same pass") {
    const fs::path other = on.plan({.name = "smooth", .factor = 0.1}, "other");
    make_part(other, 4, {}, default_backends());
    fs::copy_file(other / "done.4", plan / "done.4", fs::copy_options::overwrite_existing);
    fs::copy(directory_of(other, 4), plan / directory_of(other, 4).filename());
    const JoinResult joined = wrong();
    CHECK(joined.bad == Numbers{4});
    CHECK_THAT(joined.reasons.at(0), Catch::Contains("of another plan"));
  }
  SECTION("a block is damaged, which only --verify reads") {
    const fs::path file = directory_of(plan, 5) / "attribute1.level02.2.shard5";
    std::string bytes = bytes_of(file);
    bytes[40] = static_cast<char>(bytes[40] ^ 1);
    write(file, bytes);
    JoinOptions options;
    options.verify = true;
    CHECK(wrong(options).bad == Numbers{5});
  }
  SECTION("the store is another one, or has another version") {
    fs::create_directory(here.path() / "else");
    const Surfaces other = surfaces_of(here.path() / "else", random_sheet(5, 60));
    other.make_shards(kParts);
    const Error foreign = error_of([&] { join(plan, other.sharded()); });
    CHECK(foreign.code() == ErrorCode::kBadState);
    CHECK_THAT(foreign.what(), Catch::Contains("another store"));
    const fs::path same = on.plan(kSmooth, "same"), stale = on.plan(kSmooth, "stale");
    make_part(stale, 1, {}, default_backends());
    REQUIRE(join(plan, on.sharded()).has_store);
    CHECK(join(plan, on.sharded()).has_store);  // it is joined already
    CHECK(Store::open(on.sharded(), {}, default_backends()).sequence() == 2);
    const Error moved = part_error(stale, 0);
    CHECK(moved.code() == ErrorCode::kBadState);
    CHECK_THAT(moved.what(), Catch::Contains("expected version 1"));
    pass_in_parts(on, kSmooth);
    for (const fs::path& old : {plan, same, stale})
      CHECK(error_of([&] { join(old, on.sharded()); }).code() == ErrorCode::kBadState);
    // The store that the plan names was replaced.
    const fs::path late = on.plan(kSmooth, "late");
    fs::remove_all(on.sharded());
    fs::rename(other.sharded(), on.sharded());
    const Error replaced = part_error(late, 0);
    CHECK(replaced.code() == ErrorCode::kBadState);
    CHECK_THAT(replaced.what(), Catch::Contains("another one"));
  }
  SECTION("options that a pass does not have") {
    JoinOptions concat, replace;
    concat.concat = true;
    replace.replace = true;
    for (const JoinOptions& options : {concat, replace})
      CHECK(error_of([&] { join(plan, on.sharded(), options); }).code() ==
            ErrorCode::kInvalidArgument);
  }
}

TEST_CASE("PassJoin_AfterOneThatWasKilled_ReplacesWhatThatLeft") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.make_shards(3);
  const std::string before = digest_of(on.sharded());
  const fs::path plan = on.plan(kSmooth);
  make_parts(plan);
  // All but the manifest may be there, whole or not.
  for (const char* const name : {"attribute1.level03.2.shard1", "version.2.shard0", "version.2",
                                 "attribute1.base.2", "version.2.shard2"})
    write(on.sharded() / name, "left");
  CHECK(digest_of(on.sharded()) == before);
  REQUIRE(join(plan, on.sharded()).has_store);
  CHECK(digest_of(on.sharded()) != before);
  CHECK(check_store(on.sharded(), default_backends()).damaged.empty());
}

TEST_CASE("PassJoin_SameVersionOfAnotherPlan_IsNotTakenForItsOwn") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.make_shards(3);
  const fs::path plan = on.plan(kSmooth), other = on.plan({.factor = 0.1}, "other");
  for (const fs::path& each : {plan, other}) make_parts(each);
  REQUIRE(join(other, on.sharded()).has_store);
  const Error error = error_of([&] { join(plan, on.sharded()); });
  CHECK(error.code() == ErrorCode::kBadState);
  CHECK_THAT(error.what(), Catch::Contains("another plan"));
}

// Whatever a plan says, the store is what counts: no size of a plan takes memory before the store
// has confirmed it.
TEST_CASE("PassPlan_Forged_IsDamageOfThePlanOrRefusedInWords") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.make_shards(3);
  const fs::path plan = on.plan({.name = "noise", .amplitude = 1e-3});
  const std::string good = bytes_of(plan / "plan");
  make_parts(plan);
  const auto check = [&](const std::string& bytes) {
    write(plan / "plan", sealed(bytes));
    const auto harmless = [](const std::function<void()>& call) {
      try {
        call();
      } catch (const Error& error) {
        CAPTURE(error.what());
        CHECK(error.code() != ErrorCode::kOutOfMemory);
        CHECK(error.code() != ErrorCode::kBudget);
        CHECK_THAT(error.what(), !Catch::Contains("memory"));
      }
    };
    harmless([&] { make_part(plan, 1, {}, default_backends()); });
    harmless([&] { join(plan, on.sharded()); });
  };
  // The store goes on only by the good plan. Each eight bytes become a huge number, and each byte
  // another one.
  const std::string first = digest_of(on.sharded());
  for (std::size_t at = 0; at + 16 < good.size(); at += 3) {
    CAPTURE(at);
    std::string bytes = good;
    if (at % 2 == 0)
      std::memset(bytes.data() + at, 0xfe, 8);
    else
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << (at % 8)));
    check(bytes);
    if (digest_of(on.sharded()) != first) FAIL("a forged plan was joined");
  }
  write(plan / "plan", good);
  make_parts(plan);
  CHECK(join(plan, on.sharded()).has_store);
}

}  // namespace plait::test::passes
