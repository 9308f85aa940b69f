#include "picture/image.h"

#include <catch2/catch.hpp>

#include "picture/text.h"
#include "plait/error.h"

using namespace plait;

namespace {

constexpr Rgb kWhite{255, 255, 255}, kBlack{0, 0, 0};

std::size_t count(const Image& image, Rgb colour) {
  std::size_t pixels = 0;
  for (const Rgb& pixel : image.pixels()) pixels += pixel == colour ? 1u : 0u;
  return pixels;
}

}  // namespace

TEST_CASE("Image_SidesOutOfRange_AreRefused") {
  CHECK_THROWS_AS(Image(0, 5, kWhite), Error);
  CHECK_THROWS_AS(Image(5, 0, kWhite), Error);
  CHECK_THROWS_AS(Image(65536, 1, kWhite), Error);
  CHECK(Image(65535, 1, kWhite).pixels().size() == 65535);
}

TEST_CASE("FillRectangle_PartlyOutside_FillsWhatIsInside") {
  Image image(10, 8, kWhite);
  image.fill_rectangle(7, 6, 100, 100, kBlack);
  CHECK(count(image, kBlack) == 3 * 2);
  CHECK(image.at(7, 6) == kBlack);
  CHECK(image.at(6, 6) == kWhite);
  image.fill_rectangle(10, 8, 1, 1, kBlack);
  image.fill_rectangle(1000, 0, 5, 5, kBlack);
  CHECK(count(image, kBlack) == 3 * 2);
}

TEST_CASE("Blend_EndsMiddleAndBeyond_AreAsExpected") {
  CHECK(blend(kBlack, kWhite, 0) == kBlack);
  CHECK(blend(kBlack, kWhite, 1) == kWhite);
  CHECK(blend(kBlack, kWhite, 0.5) == Rgb{128, 128, 128});
  CHECK(blend(kBlack, kWhite, -3) == kBlack);
  CHECK(blend(kBlack, kWhite, 7) == kWhite);
}

TEST_CASE("DrawText_LetterI_HasItsPixelsAtEveryScale") {
  for (const std::size_t scale : {1u, 2u, 3u}) {
    Image image(60, 40, kWhite);
    draw_text(image, 2, 3, "i", kBlack, scale);
    CHECK(count(image, kBlack) == 11 * scale * scale);
    CHECK(image.at(2 + scale, 3) == kBlack);
    CHECK(image.at(2, 3) == kWhite);
  }
}

TEST_CASE("DrawText_UnknownOrBeyondTheEdge_DrawsNothingThere") {
  Image image(20, 10, kWhite);
  draw_text(image, 0, 0, "\xff~ ", kBlack, 1);
  draw_text(image, 100, 100, "ABC", kBlack, 2);
  CHECK(count(image, kBlack) == 0);
}
