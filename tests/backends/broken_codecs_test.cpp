// The conformance suite finds what is broken in codecs: codecs with one mistake each, and the
// promise that each of them breaks.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "conformance/suite.h"
#include "plait/error.h"
#include "plait/extend/codec.h"
#include "plait/registry.h"

namespace plait::test {
namespace {

struct CodecMistake {
  bool salts = false;      ///< each encoding has another byte at its end
  bool depends = false;    ///< an encoding depends on the block before
  bool follows = false;    ///< the decoder reads as far as the stored length says
  bool loses_bit = false;  ///< in one block of a hundred
  bool other_error = false;
};

/// The codec lz4 with a length in front, and one mistake.
class BrokenCodec final : public Codec {
 public:
  explicit BrokenCodec(const CodecMistake& mistake)
      : inner_(default_pipelines().make_codec({"lz4", {}})), mistake_(mistake) {}

  std::size_t bound(std::size_t raw_bytes) const override { return inner_->bound(raw_bytes) + 5; }
  std::size_t memory_bytes(std::size_t raw_bytes) const override {
    return inner_->memory_bytes(raw_bytes);
  }
  std::optional<std::size_t> compress(std::span<const std::byte> raw,
                                      std::span<std::byte> into) override {
    if (into.size() < 6) return std::nullopt;
    const auto bytes = inner_->compress(raw, into.subspan(5));
    if (!bytes) return std::nullopt;
    const auto length = static_cast<std::uint32_t>(*bytes);
    std::memcpy(into.data(), &length, 4);
    into[4] = mistake_.salts || mistake_.depends ? last_ : std::byte{};
    if (mistake_.salts) last_ = static_cast<std::byte>(std::to_integer<int>(last_) + 1);
    if (mistake_.depends) last_ = raw[0];
    return *bytes + 5;
  }
  void decompress(std::span<const std::byte> stored, std::span<std::byte> raw) override {
    std::uint32_t length = 0;
    if (stored.size() >= 4) std::memcpy(&length, stored.data(), 4);
    const bool right = stored.size() >= 5 && length == stored.size() - 5;
    if (!right && mistake_.follows) {
      volatile int sum = 0;  // what the length says is there
      for (std::size_t at = 0; at < std::min<std::size_t>(length, 1 << 20); ++at)
        sum = sum + std::to_integer<int>(stored.data()[5 + at]);
    }
    if (!right)
      throw Error(mistake_.other_error ? ErrorCode::kIo : ErrorCode::kCorruption, "decode: wrong");
    inner_->decompress(stored.subspan(5), raw);
    if (mistake_.loses_bit && ++decoded_ % 100 == 0) raw[0] ^= std::byte{4};
  }

 private:
  std::unique_ptr<Codec> inner_;
  CodecMistake mistake_;
  std::byte last_{};
  int decoded_ = 0;
};

conformance::CheckLog checked(const CodecMistake& mistake, std::string_view name) {
  conformance::Subject subject;
  subject.label = "broken";
  subject.entry = default_backends().find("compressed");
  subject.make_codec = [=] { return std::make_unique<BrokenCodec>(mistake); };
  subject.codec_blocks = 1000;
  const auto promise =
      std::ranges::find(conformance::promises(), name, &conformance::Promise::name);
  return conformance::check(*promise, subject);
}

bool broken(const CodecMistake& mistake, std::string_view name) {
  const conformance::CheckLog log = checked(mistake, name);
  for (const std::string& each : log.broken()) UNSCOPED_INFO(each);
  return !log.held();
}

}  // namespace

TEST_CASE("Conformance_CodecWithAMistake_BreaksThePromise") {
  constexpr const char* kAll[] = {"codec-gives-back", "codec-is-repeatable", "codec-stays-inside"};
  for (const char* name : kAll) CHECK_FALSE(broken({}, name));
  const auto breaks = [&](const CodecMistake& mistake, std::string_view only) {
    for (const char* name : kAll) {
      CAPTURE(name, only);
      CHECK(broken(mistake, name) == (name == only));
    }
  };
  breaks({.salts = true}, "codec-is-repeatable");
  breaks({.depends = true}, "codec-is-repeatable");
  breaks({.follows = true}, "codec-stays-inside");
  breaks({.other_error = true}, "codec-stays-inside");
  breaks({.loses_bit = true}, "codec-gives-back");
}

TEST_CASE("Conformance_OfACodec_SaysHowManyBlocksWereEncoded") {
  CHECK(checked({}, "codec-gives-back").note().find(" of 1000 blocks were encoded") !=
        std::string::npos);
}

}  // namespace plait::test
