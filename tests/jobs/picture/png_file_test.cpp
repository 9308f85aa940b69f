#include "picture/png_file.h"

#include <png.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "plait/error.h"
#include "support/temporary_directory.h"

using namespace plait;

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

std::string content(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
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
  const std::string first = content(directory.path() / "a.png");
  write_png(test_card(), directory.path() / "a.png");
  CHECK(content(directory.path() / "a.png") == first);
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
