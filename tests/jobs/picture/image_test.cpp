#include "picture/image.h"

#include <png.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "picture/png_file.h"
#include "picture/text.h"
#include "plait/error.h"
#include "support/file_bytes.h"
#include "support/temporary_directory.h"

namespace plait::test {
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

namespace {

Image test_card() {
  Image image(37, 21, {255, 255, 255});
  for (std::size_t y = 0; y < image.height(); ++y)
    for (std::size_t x = 0; x < image.width(); ++x)
      image.at(x, y) = {static_cast<std::uint8_t>(6 * x), static_cast<std::uint8_t>(11 * y),
                        static_cast<std::uint8_t>(x * y)};
  return image;
}

std::vector<Rgb> read_png(const std::filesystem::path& path) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_file(&header, path.c_str()) != 0);
  header.format = PNG_FORMAT_RGB;
  CHECK(header.width == 37);
  CHECK(header.height == 21);
  std::vector<Rgb> pixels(header.width * header.height);
  REQUIRE(png_image_finish_read(&header, nullptr, pixels.data(), 0, nullptr) != 0);
  return pixels;
}

std::size_t file_count(const std::filesystem::path& directory) {
  return static_cast<std::size_t>(
      std::distance(std::filesystem::directory_iterator(directory), {}));
}

}  // namespace

TEST_CASE("WritePng_ReadByLibpng_GivesTheSamePixels") {
  const test::TemporaryDirectory directory;
  const Image image = test_card();
  write_png(image, directory.path() / "card.png");
  const std::vector<Rgb> pixels = read_png(directory.path() / "card.png");
  CHECK(std::equal(pixels.begin(), pixels.end(), image.pixels().begin(), image.pixels().end()));
}

TEST_CASE("WritePng_Twice_GivesTheSameBytesAndOneFile") {
  const test::TemporaryDirectory directory;
  write_png(test_card(), directory.path() / "a.png");
  const std::string first = content_of(directory.path() / "a.png");
  write_png(test_card(), directory.path() / "a.png");
  CHECK(content_of(directory.path() / "a.png") == first);
  CHECK(file_count(directory.path()) == 1);
}

TEST_CASE("WritePng_NoSuchDirectory_IsNotFoundNamingThePath") {
  const test::TemporaryDirectory directory;
  try {
    write_png(test_card(), directory.path() / "absent" / "a.png");
    FAIL("no error");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kNotFound);
    CHECK(std::string(error.what()).find("absent") != std::string::npos);
  }
}

TEST_CASE("WritePng_PathIsADirectory_IsRefusedAndLeavesNothing") {
  const test::TemporaryDirectory directory;
  std::filesystem::create_directories(directory.path() / "a.png" / "full");
  CHECK_THROWS_AS(write_png(test_card(), directory.path() / "a.png"), Error);
  CHECK(file_count(directory.path()) == 1);
}

}  // namespace plait::test
