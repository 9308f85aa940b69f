#include "span_diagram.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "picture/png_file.h"
#include "picture/text.h"
#include "plait/error.h"
#include "plait/layout.h"

namespace plait {
namespace {

constexpr std::size_t kMostPixels = 1200, kFewestPixels = 480;  // of a panel's side
constexpr std::size_t kMargin = 24, kFrame = 1;
constexpr std::size_t kLineHeight = kGlyphHeight + 4;  // at scale 1
constexpr Rgb kPaper{255, 255, 255}, kText{40, 44, 52}, kFrameColour{168, 174, 184};
constexpr Rgb kFaint{150, 190, 225}, kInk{8, 36, 92};

/// Counts dots in bins, at most kMostPixels per side. If there are fewer elements than
/// kFewestPixels, each is drawn as a square of several pixels.
class DotCounter {
 public:
  DotCounter(std::size_t row_count, std::size_t column_count)
      : row_count_(row_count),
        column_count_(column_count),
        rows_(std::min(row_count, kMostPixels)),
        columns_(std::min(column_count, kMostPixels)),
        counts_(rows_ * columns_, 0) {}

  void add(std::size_t row, std::size_t column) {
    ++counts_[row * rows_ / row_count_ * columns_ + column * columns_ / column_count_];
  }

  std::size_t width() const { return columns_ * magnification(columns_); }
  std::size_t height() const { return rows_ * magnification(rows_); }

  void draw(Image& image, std::size_t left, std::size_t top) const {
    const double most = *std::max_element(counts_.begin(), counts_.end());
    const std::size_t dot_width = magnification(columns_), dot_height = magnification(rows_);
    for (std::size_t row = 0; row < rows_; ++row) {
      for (std::size_t column = 0; column < columns_; ++column) {
        const std::uint32_t count = counts_[row * columns_ + column];
        if (count == 0) continue;
        // The colour follows the logarithm of the count. A single dot is still clearly visible,
        // because one outlier decides the span.
        const double darkness = most > 1 ? std::log(count) / std::log(most) : 1;
        image.fill_rectangle(left + column * dot_width, top + row * dot_height, dot_width,
                             dot_height, blend(kFaint, kInk, darkness));
      }
    }
  }

 private:
  static std::size_t magnification(std::size_t bins) {
    return std::max<std::size_t>(1, (kFewestPixels + bins - 1) / bins);
  }

  std::size_t row_count_, column_count_, rows_, columns_;
  std::vector<std::uint32_t> counts_;
};

DotCounter count_face_dots(const BaseMesh& mesh) {
  DotCounter dots(mesh.face_count(), mesh.edge_count());
  for (std::size_t face = 0; face < mesh.face_count(); ++face)
    for (const EdgeId edge : mesh.face_edges()[face]) dots.add(face, edge);
  return dots;
}

DotCounter count_loop_dots(const BaseMesh& mesh) {
  DotCounter dots(mesh.edge_count(), mesh.edge_count());
  for (EdgeId edge = 0; edge < mesh.edge_count(); ++edge) {
    dots.add(edge, edge);
    for (const FaceSide side : {mesh.edges()[edge].own, mesh.edges()[edge].other}) {
      if (!side.exists()) continue;
      for (const EdgeId used : mesh.face_edges()[side.face()])
        if (used != edge) dots.add(edge, used);
    }
  }
  return dots;
}

std::string with_separators(std::uint64_t number) {
  std::string digits = std::to_string(number);
  for (std::size_t end = digits.size(); end > 3;) digits.insert(end -= 3, 1, ',');
  return digits;
}

/// The largest scale at which two captions of the usual length fit side by side.
std::size_t caption_scale(std::size_t panel_width) {
  constexpr std::size_t kCaptionCharacters = 48, kLargest = 3;
  return std::clamp<std::size_t>(panel_width / (kCaptionCharacters * kGlyphAdvance), 1, kLargest);
}

void draw_panel(Image& image, std::size_t left, const DotCounter& dots, const std::string& title,
                const StencilSpan& span, std::size_t text_scale) {
  draw_text(image, left, kMargin, title, kText, text_scale);
  draw_text(image, left, kMargin + text_scale * kLineHeight,
            fmt::format("span {}  mean {:.1f}  median {}", with_separators(span.span),
                        span.mean_width, with_separators(span.median_width)),
            kText, text_scale);
  const std::size_t top = kMargin + 2 * text_scale * kLineHeight + kFrame;
  image.fill_rectangle(left, top - kFrame, dots.width() + 2 * kFrame, dots.height() + 2 * kFrame,
                       kFrameColour);
  image.fill_rectangle(left + kFrame, top, dots.width(), dots.height(), kPaper);
  dots.draw(image, left + kFrame, top);
}

}  // namespace

Image span_diagram(const BaseMesh& mesh) {
  if (mesh.face_count() == 0)
    throw Error(ErrorCode::kInvalidArgument, "draw spans: expected a mesh with faces, found none");
  const DotCounter face_dots = count_face_dots(mesh), loop_dots = count_loop_dots(mesh);
  const LayoutSpans spans = measure_spans(mesh);
  const std::size_t text_scale = caption_scale(std::min(face_dots.width(), loop_dots.width()));
  const std::size_t second_left = 2 * kMargin + face_dots.width() + 2 * kFrame;
  const std::size_t width = second_left + loop_dots.width() + 2 * kFrame + kMargin;
  const std::size_t height = 2 * kMargin + 2 * text_scale * kLineHeight + 2 * kFrame +
                             std::max(face_dots.height(), loop_dots.height());
  Image image(width, height, kPaper);
  draw_panel(image, kMargin, face_dots,
             fmt::format("{} faces x {} edges", with_separators(mesh.face_count()),
                         with_separators(mesh.edge_count())),
             spans.face, text_scale);
  draw_panel(image, second_left, loop_dots,
             fmt::format("{} Loop stencils x {} edges", with_separators(mesh.edge_count()),
                         with_separators(mesh.edge_count())),
             spans.loop, text_scale);
  return image;
}

void draw_span_diagram(const BaseMesh& mesh, File& file) { write_png(span_diagram(mesh), file); }

}  // namespace plait
