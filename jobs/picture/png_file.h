// picture/png_file.h: writes images to PNG files.
#pragma once

#include <filesystem>

#include "picture/image.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_NAMESPACE

/// Replaces `path` by an 8-bit RGB PNG. The file gets its name only when it is complete. The same
/// image gives the same bytes. Memory: twice the image.
/// Errors: kIo, kNoSpace, kNotFound (the directory). After an error `path` is unchanged.
void write_png(const Image& image, const std::filesystem::path& path);
/// Writes the same bytes into a file that is open and empty.
void write_png(const Image& image, File& file);

PLAIT_END_NAMESPACE
