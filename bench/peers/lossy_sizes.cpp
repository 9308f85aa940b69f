// How small do positions get if each coordinate may change by a bound?
//
//   plait_bench_lossy_sizes [--refinements 4] [--level 5] [--directory DIR]
//
// Three surfaces: a Loop surface; with noise of 3e-7 diagonals; with a fractal of 0.005 diagonals.
// For each bound, the bytes a vertex of all levels, and the largest error measured on what a reader
// gets. Every way gets the coarsest setting whose measured error is within the bound. Draco and the
// quantised array store a mesh of one level, plait all levels with random access. Draco's
// edgebreaker changes the order of vertices, so its error is that of the same quantisation in the
// sequential encoding; its bytes include the triangles. The program prints a Markdown table.
#include <fmt/format.h>
#include <zstd.h>
#if defined(PLAIT_BENCH_DRACO)
#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include "micro/command_line.h"
#include "micro/support.h"
#include "peers/coders.h"
#include "plait/compression.h"
#include "plait/extend/copy_levels.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/rounding.h"
#include "plait/extend/store_access.h"
#include "plait/extend/vertex_numbering.h"
#include "plait/registry.h"

namespace {

using namespace plait;
using namespace plait::bench;

struct LossySize {
  std::size_t bytes = 0;
  double largest_error = 0;  ///< of a coordinate
};

double largest_error(const Points& a, const Points& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      largest = std::max(largest, std::abs(double{a[i][axis]} - double{b[i][axis]}));
  return largest;
}

LossySize size_in_plait(const Settings& settings, Store& surface, const Points& points,
                        const std::string& preset, double bound) {
  std::filesystem::remove_all(settings.store());
  ErrorBounds bounds;
  bounds.add(fmt::format("{}", bound));
  const AttributeId id = surface.attribute("position");
  const Rounder rounder(surface.attributes()[id].schema, *bounds.of("position"),
                        std::as_const(surface).base_bytes(id));
  StoreOptions options;
  options.backend = "compressed";
  options.durability = Durability::kNone;
  options.pipeline_of = [&](const AttributeSchema& schema) {
    return pipeline_of_rounded(preset_pipeline(preset, schema), rounder.step());
  };
  Store copy = Store::create(settings.store(), surface.base(), options, default_backends(),
                             surface.provenance());
  copy_levels(surface, copy, {}, bounds);
  copy.commit();
  LossySize size;
  size.bytes = std::as_const(copy).base_bytes(id).size();
  for (int level = 1; level <= settings.level; ++level)
    size.bytes += StoreAccess::level_file(copy, id, level).backend->stored_bytes();
  size.largest_error = largest_error(points, positions_of(copy));
  return size;
}

/// Indices of multiples of the step, as 32-bit integers by significance of their bytes.
LossySize size_quantised(const Points& points, double bound) {
  const double step = 2 * bound * (1 - 1e-3);
  const std::size_t count = 3 * points.size();
  std::vector<unsigned char> planes(4 * count);
  LossySize size;
  for (std::size_t i = 0; i < count; ++i) {
    const double number = points[i / 3][static_cast<int>(i % 3)];
    const double index = std::nearbyint(number / step);
    const auto word = static_cast<std::uint32_t>(static_cast<std::int64_t>(index) + 0x40000000);
    for (std::size_t byte = 0; byte < 4; ++byte)
      planes[byte * count + i] = static_cast<unsigned char>(word >> 8 * byte);
    const double back = static_cast<float>(index * step);
    size.largest_error = std::max(size.largest_error, std::abs(back - number));
  }
  std::vector<unsigned char> to(ZSTD_compressBound(planes.size()));
  size.bytes = ZSTD_compress(to.data(), to.size(), planes.data(), planes.size(), 19);
  return size;
}

#if defined(PLAIT_BENCH_ZFP)
/// Every level is a grid of its own, of the slots one below another.
std::optional<LossySize> zfp_size(const Store& store, const Points& points, double bound) {
  const VertexNumbering numbering(store.base().topology(), store.finest_level());
  // It takes the power of two below the tolerance.
  for (double tolerance = 16 * bound; tolerance > bound / 64; tolerance /= 2) {
    const Coder coder = zfp(tolerance);
    Points back = points;
    LossySize size{numbering.first_of(1) * sizeof(points[0])};
    for (int level = 1; level <= store.finest_level(); ++level) {
      const std::size_t first = numbering.first_of(level);
      const std::size_t count = numbering.first_of(level + 1) - first;
      const auto side = static_cast<std::size_t>(slot_side(level));
      const RawBlock block{0, std::as_bytes(std::span(points).subspan(first, count)), side,
                           count / side};
      std::vector<std::byte> to(most_encoded(block.raw.size()));
      const std::size_t encoded = coder.encode(block, to);
      coder.decode(std::span(to).first(encoded), block,
                   std::as_writable_bytes(std::span(back).subspan(first, count)));
      size.bytes += encoded;
    }
    size.largest_error = largest_error(points, back);
    if (size.largest_error <= bound) return size;
  }
  return {};
}
#endif

#if defined(PLAIT_BENCH_DRACO)
void fill_mesh(const Store& store, const Points& points, draco::Mesh& to) {
  to.set_num_points(static_cast<std::uint32_t>(points.size()));
  draco::GeometryAttribute position;
  position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, 12, 0);
  const int id = to.AddAttribute(position, true, to.num_points());
  for (std::uint32_t i = 0; i < to.num_points(); ++i)
    to.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), &points[i]);
  const int level = store.finest_level();
  const VertexNumbering numbering(store.base().topology(), level);
  for (FaceId face = 0; face < store.base().face_count(); ++face)
    for_each_triangle(level, [&](const std::array<FacePoint, 3>& corners) {
      draco::Mesh::Face triangle;
      for (std::size_t i = 0; i < 3; ++i)
        triangle[i] = draco::PointIndex(static_cast<std::uint32_t>(
            numbering.number({face, level, corners[i].i, corners[i].j})));
      to.AddFace(triangle);
    });
}

std::optional<draco::EncoderBuffer> encode_mesh(const draco::Mesh& mesh, int method, int bits,
                                                int speed) {
  draco::Encoder encoder;
  encoder.SetEncodingMethod(method);
  encoder.SetSpeedOptions(speed, speed);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, bits);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeMeshToBuffer(mesh, &buffer).ok()) return {};
  return buffer;
}

/// The largest error of quantisation to this number of bits, in the encoding that keeps the order.
double error_of(const Points& points, const draco::Mesh& same, int bits) {
  const auto buffer = encode_mesh(same, draco::MESH_SEQUENTIAL_ENCODING, bits, 10);
  if (!buffer) return INFINITY;
  draco::DecoderBuffer input;
  input.Init(buffer->data(), buffer->size());
  auto decoded = draco::Decoder().DecodeMeshFromBuffer(&input);
  if (!decoded.ok()) return INFINITY;
  const draco::PointAttribute* const position =
      decoded.value()->GetNamedAttribute(draco::GeometryAttribute::POSITION);
  Points back(points.size());
  for (std::uint32_t i = 0; i < back.size(); ++i)
    position->GetMappedValue(draco::PointIndex(i), &back[i]);
  return largest_error(points, back);
}

/// The edgebreaker at its smallest, with the triangles of the finest level.
std::optional<LossySize> draco_size(const Store& store, const Points& points, double bound) {
  draco::Mesh same;
  fill_mesh(store, points, same);
  for (int bits = 8; bits <= 30; ++bits) {
    const double error = error_of(points, same, bits);
    if (error > bound) continue;
    if (const auto buffer = encode_mesh(same, draco::MESH_EDGEBREAKER_ENCODING, bits, 0))
      return LossySize{buffer->size(), error};
  }
  return {};
}
#endif

void run(const Settings& settings) {
  const LaidOutMesh base = mesh_or_octahedron({}, settings.refinements, LayoutKind::kAutomatic);
  Measurements table("surface|#bound, diagonals|way",
                     {{"bytes a vertex", 3}, {"largest error / bound", 3}});
  for (const std::string surface : {"exact", "noise", "fractal"}) {
    Store store = make_surface(settings, base, surface, false);
    const Points points = positions_of(store);
    const ErrorBound one{1, true};
    const double diagonal =
        Rounder(store.attributes()[0].schema, one, std::as_const(store).base_bytes(0))
            .result()
            .bound;
    for (const double relative : {1e-4, 1e-5, 1e-6}) {
      const double bound = relative * diagonal;
      const auto add = [&](const std::string& way, const std::optional<LossySize>& size) {
        say_progress(fmt::format("{} {} {}", surface, relative, way));
        if (!size) return;
        const auto vertices = static_cast<double>(points.size());
        table.add({surface, fmt::format("{:g}", relative), way},
                  {static_cast<double>(size->bytes) / vertices, size->largest_error / bound});
      };
      for (const char* preset : {"fast", "default", "small"})
        add(preset, size_in_plait(settings, store, points, preset, bound));
      add("quantise, shuffle, zstd 19", size_quantised(points, bound));
#if defined(PLAIT_BENCH_ZFP)
      add("zfp, accuracy, 2-D", zfp_size(store, points, bound));
#endif
#if defined(PLAIT_BENCH_DRACO)
      add("Draco, edgebreaker, speed 0", draco_size(store, points, bound));
#endif
    }
  }
  table.print(fmt::format("positions to level {}", settings.level));
}

}  // namespace

int main(int count, char** words) {
  return Program("plait_bench_lossy_sizes", "Size of rounded positions, beside other libraries",
                 {.directory = "/tmp", .refinements = 4, .block_kib = 256},
                 {"--refinements", "--level", "--directory"})
      .run(count, words, run);
}
