// backends/compressed/codecs/built_in_codecs.h: the codecs of the library.
#pragma once

#include <memory>
#include <string_view>

#include "plait/extend/codec.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// `options` is the text after the colon. Errors: kInvalidArgument for options that the codec does
/// not have.
std::unique_ptr<Codec> make_none_codec(std::string_view options);
std::unique_ptr<Codec> make_bitpack_codec(std::string_view options);
std::unique_ptr<Codec> make_lz4_codec(std::string_view options);
/// `options` is a level from ZSTD_minCLevel() to ZSTD_maxCLevel(); empty for zstd's default level.
std::unique_ptr<Codec> make_zstd_codec(std::string_view options);

/// Throws kInvalidArgument unless `options` is empty.
void refuse_options(std::string_view name, std::string_view options);

PLAIT_END_NAMESPACE
