// picture/png_file.h: images to PNG files.
#pragma once

#include <filesystem>

#include "picture/image.h"
#include "plait/file.h"

namespace plait {

/// Replaces `path` by an 8-bit RGB PNG, which appears under its name only when it is whole. The
/// same image gives the same bytes. Memory: twice the image.
/// Errors: kIo, kNoSpace, kNotFound (the directory); then `path` is as it was.
void write_png(const Image& image, const std::filesystem::path& path);
/// Into a file that is open and empty.
void write_png(const Image& image, File& file);

}  // namespace plait
