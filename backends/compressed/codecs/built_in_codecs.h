// backends/compressed/codecs/built_in_codecs.h: the codecs that are always there.
#pragma once

#include <memory>
#include <string_view>

#include "plait/backends/pipeline.h"

namespace plait {

/// Each takes the options of its name. Errors: kInvalidArgument for options that it has not.
std::unique_ptr<Codec> make_none_codec(std::string_view options);
std::unique_ptr<Codec> make_lz4_codec(std::string_view options);
/// A level from ZSTD_minCLevel() to ZSTD_maxCLevel(), or nothing for zstd's default level.
std::unique_ptr<Codec> make_zstd_codec(std::string_view options);

/// Errors: kInvalidArgument unless `options` is empty.
void refuse_options(std::string_view name, std::string_view options);

}  // namespace plait
