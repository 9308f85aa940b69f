// The file view of stores whose faces have depths of their own: what it says of each face, which
// files are refused, and that the records which viewers read are those of the store.
#include <algorithm>
#include <boost/iostreams/device/array.hpp>
#include <boost/iostreams/device/back_inserter.hpp>
#include <boost/iostreams/filter/zlib.hpp>
#include <boost/iostreams/filtering_stream.hpp>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "conversion/conversion_job.h"
#include "format/checksum.h"
#include "format/view_file.h"
#include "jobs/pruned_stores.h"
#include "plait/extend/check_store.h"
#include "plait/extend/store_access.h"
#include "publish/make_view.h"
#include "publish/served_store.h"
#include "store/store_state.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test::view_test {
namespace {

namespace fs = std::filesystem;
namespace io = boost::iostreams;

template <class Number>
Number number_at(std::span<const std::byte> bytes, std::size_t at) {
  Number number;
  std::memcpy(&number, &bytes[at], sizeof(number));
  return number;
}

/// A view, with its content unpacked.
struct Unpacked {
  std::vector<std::byte> head, table;
  std::vector<char> content;

  explicit Unpacked(std::span<const std::byte> view)
      : head(view.begin(), view.begin() + 120),
        table(view.begin() + 120, view.begin() + 120 + number_at<std::int64_t>(view, 104)) {
    io::filtering_istream stream;
    stream.push(io::zlib_decompressor());
    stream.push(io::array_source(reinterpret_cast<const char*>(&view[120 + table.size()]),
                                 number_at<std::uint64_t>(view, 112)));
    content.assign(std::istreambuf_iterator<char>(stream), {});
  }
  std::vector<std::byte> packed() const {
    std::vector<char> z;
    io::filtering_ostream stream;
    stream.push(io::zlib_compressor());
    stream.push(io::back_inserter(z));
    stream.write(content.data(), static_cast<std::streamsize>(content.size()));
    stream.reset();
    std::vector<std::byte> view = head;
    const std::uint64_t size = z.size();
    std::memcpy(&view[112], &size, 8);
    view.insert(view.end(), table.begin(), table.end());
    for (const char c : z) view.push_back(static_cast<std::byte>(c));
    const std::uint64_t checksum = checksum_of(view);
    view.resize(view.size() + 8);
    std::memcpy(&view[view.size() - 8], &checksum, 8);
    return view;
  }
  std::size_t levels() const { return number_at<std::uint32_t>(head, 12); }
  std::size_t faces() const { return number_at<std::uint64_t>(head, 48); }
  std::size_t first_depth() const { return content.size() - (levels() + 1) * faces(); }
  int depth(FaceId face) const { return static_cast<unsigned char>(content[first_depth() + face]); }
  /// [depth * faces + face] as the bytes say it.
  std::vector<double> errors() const {
    std::vector<unsigned char> bytes(
        content.end() - static_cast<std::ptrdiff_t>(levels() * faces()), content.end());
    for (std::size_t i = 1; i < bytes.size(); ++i)
      bytes[i] = static_cast<unsigned char>(bytes[i] + bytes[i >= faces() ? i - faces() : i - 1]);
    std::vector<double> errors;
    for (const unsigned char byte : bytes)
      errors.push_back(byte == 0 ? 0 : number_at<double>(head, 96) * std::exp2((byte - 255) / 2.0));
    return errors;
  }
};

/// What the error of a face at a depth must be, from the store of all levels. A vertex counts if
/// the face has it, or a neighbour at whose side it is.
double expected_error(const Store& whole, const std::vector<std::uint8_t>& depths, FaceId face,
                      int depth) {
  const Topology mesh = whole.base().topology();
  double sum = 0;
  for (int level = depth + 1; level <= kLevels; ++level) {
    const std::vector<Position> patch = patch_of(whole, face, level);
    const std::int64_t size = std::int64_t{1} << level;
    double most = 0;
    for (std::int64_t j = 0; j <= size; ++j)
      for (std::int64_t i = 0; i + j <= size; ++i) {
        if (i % 2 == 0 && j % 2 == 0) continue;
        const int side = i + j == size ? 0 : i == 0 ? 1 : j == 0 ? 2 : -1;
        bool has = depths[face] >= level;
        if (side >= 0)
          if (const FaceSide beyond = mesh.across(FaceSide(face, side)); beyond.exists())
            has |= depths[beyond.face()] >= level;
        if (!has) continue;
        const std::int64_t di = i % 2, dj = j % 2, turn = di & dj;
        const auto at = [&](std::int64_t x, std::int64_t y) {
          return patch[static_cast<std::size_t>(patch_vertex(size, x, y))];
        };
        const Position a = at(i - di, j - dj + 2 * turn), b = at(i + di, j + dj - 2 * turn),
                       here = at(i, j);
        double squares = 0;
        for (int axis = 0; axis < 3; ++axis)
          squares += std::pow(double{here[axis]} - (double{a[axis]} + double{b[axis]}) / 2, 2);
        most = std::max(most, std::sqrt(squares));
      }
    sum += most;
  }
  return sum;
}

struct Stores {
  TemporaryDirectory here{Medium::kMemory};
  std::vector<std::uint8_t> depths;
  Store whole, thin;

  explicit Stores(const IndexedMesh& mesh, unsigned seed)
      : depths([&] {
          std::mt19937 random(seed);
          return random_depths(BaseMesh::build(mesh).face_count(), random, kLevels);
        }()),
        whole(open(whole_store(here.path() / "whole.plait", mesh, depths))),
        thin([&] {
          pruned(here.path() / "whole.plait", here.path() / "thin.plait", 0);
          return open(here.path() / "thin.plait");
        }()) {}
  ViewedStore viewed() const {
    return {StoreAccess::state(thin).uuid, thin.base().vertex_count(), thin.base().face_count(),
            depths};
  }
};

}  // namespace

TEST_CASE("MakeView_OfFacesWithDepths_HasThemAndHowFarEachDepthIsFromWhatTheStoreHas") {
  for (const unsigned seed : {1u, 2u, 3u}) {
    Stores stores(seed == 2 ? sheet(5, 4) : torus_grid(6, 5), seed);
    const Unpacked view(make_view(stores.thin));
    CAPTURE(seed);
    REQUIRE(number_at<std::uint16_t>(view.head, 58) == 1);
    const std::vector<double> errors = view.errors();
    REQUIRE(errors.size() == kLevels * view.faces());
    const double largest = *std::ranges::max_element(errors);
    for (FaceId face = 0; face < view.faces(); ++face) {
      CHECK(view.depth(face) == stores.depths[face]);
      for (int depth = 0; depth < kLevels; ++depth) {
        const double found = errors[static_cast<std::size_t>(depth) * view.faces() + face],
                     expected = expected_error(stores.whole, stores.depths, face, depth);
        CAPTURE(face, depth, found, expected);
        CHECK(found >= expected * 0.999999);
        CHECK(found <= std::max(expected * std::sqrt(2) * 1.000001,
                                expected > 0 ? largest * std::exp2(-127) : 0));
      }
    }
  }
}

TEST_CASE("CheckView_DepthsThatAreNotThoseOfTheStore_AreRefusedInWords") {
  Stores stores(torus_grid(6, 5), 1);
  const std::vector<std::byte> right = make_view(stores.thin);
  const auto reason = [&](const Unpacked& view, const ViewedStore& expected) {
    return std::string(error_of([&] { check_view(view.packed(), "view", expected); }).what());
  };
  const Unpacked whole(right);
  check_view(whole.packed(), "view", stores.viewed());
  const FaceId last = static_cast<FaceId>(whole.faces() - 1);
  for (const int depth : {4, 21, 255}) {
    Unpacked forged = whole;
    forged.content[forged.first_depth() + last] = static_cast<char>(depth);
    CHECK_THAT(
        reason(forged, stores.viewed()),
        Catch::Contains("depth " + std::to_string(depth) + " of face " + std::to_string(last) +
                        ", expected " + std::to_string(stores.depths[last])));
  }
  Unpacked cut = whole;
  cut.content.erase(cut.content.begin() + static_cast<std::ptrdiff_t>(cut.first_depth()));
  CHECK_THAT(reason(cut, stores.viewed()), Catch::Contains("content has not"));
  for (const int flag : {0, 2}) {
    Unpacked other = whole;
    other.head[58] = static_cast<std::byte>(flag);
    CHECK_THAT(reason(other, stores.viewed()),
               Catch::Contains("whether faces have depths of their own, expected 1"));
  }
  ViewedStore without = stores.viewed();
  without.depths = {};
  CHECK_THAT(reason(whole, without),
             Catch::Contains("1 for whether faces have depths of their own, expected 0"));
}

TEST_CASE("CheckStore_AViewWithOtherDepths_IsANoteAndServedInItsPlaceIsAnError") {
  Stores stores(torus_grid(6, 5), 1);
  Unpacked forged(make_view(stores.thin));
  const fs::path file = stores.here.path() / "thin.plait/view";
  const auto put = [&] {
    const std::vector<std::byte> bytes = forged.packed();
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  };
  put();
  CHECK(check_store(stores.here.path() / "thin.plait", default_backends()).notes.empty());
  CHECK(!view_of(stores.thin).empty());
  char& depth = forged.content[forged.first_depth()];
  depth = static_cast<char>(depth ^ 1);
  put();
  const StoreCheck check = check_store(stores.here.path() / "thin.plait", default_backends());
  REQUIRE(check.notes.size() == 1);
  CHECK_THAT(check.notes[0], Catch::Contains("the view, which can be made again") &&
                                 Catch::Contains("of face 0, expected"));
  CHECK(code_of([&] { view_of(stores.thin); }) == ErrorCode::kCorruption);
}

TEST_CASE("ServedStore_OfFacesWithDepths_ServesTheRecordsThatTheStoreHas") {
  for (const std::string backend : {"pread", "compressed"}) {
    Stores stores(sheet(5, 4), 5);
    const ConversionRequest request{.from = stores.here.path() / "thin.plait",
                                    .to = stores.here.path() / "copy.plait",
                                    .backend = backend};
    convert(request, default_backends(), default_backends());
    Store copy = open(stores.here.path() / "copy.plait");
    const ServedStore served(copy, {});
    const Reader reader(stores.thin, {.attributes = {"position"}});
    const AttributeId position = stores.thin.attribute("position");
    for (const ViewedFile& file : viewed_files(copy)) {
      if (file.attribute != position) continue;
      const ServedStore::File* const found = served.find('/' + file.name);
      REQUIRE(found != nullptr);
      CAPTURE(backend, file.name);
      REQUIRE(found->bytes == reader.vertex_count(file.level) * sizeof(Position));
      std::vector<std::byte> bytes(found->bytes), expected;
      for (std::size_t at = 0; at < bytes.size(); at += 1000)
        served.read(*found, at,
                    std::span(bytes).subspan(at, std::min<std::size_t>(1000, bytes.size() - at)));
      reader.for_each_block_of_bytes("position", file.level, 0, reader.vertex_count(file.level),
                                     [&](std::uint64_t, std::span<const std::byte> block) {
                                       expected.insert(expected.end(), block.begin(), block.end());
                                     });
      CHECK(bytes == expected);
    }
  }
}

}  // namespace plait::test::view_test
