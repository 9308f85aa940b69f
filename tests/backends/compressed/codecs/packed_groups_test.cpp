// packed_groups.h: its bits are those of docs/filters/bitpack.md, on every instruction set, and no
// byte outside the packed ones is read.
#include "compressed/codecs/packed_groups.h"

#include <catch2/catch.hpp>
#include <memory>
#include <random>
#include <vector>

#include "rows/every_target.h"

namespace plait::test {
namespace {

/// The definition: bit b of word i of a group is bit i * width + b of the group.
std::vector<std::byte> packed_by_definition(const std::vector<std::uint32_t>& words,
                                            const std::vector<std::uint32_t>& widths) {
  std::vector<bool> bits;
  for (std::size_t i = 0; i < words.size(); ++i)
    for (std::uint32_t bit = 0; bit < widths[i / kGroupWords]; ++bit)
      bits.push_back((words[i] >> bit & 1) != 0);
  std::vector<std::byte> packed(bits.size() / 8);
  for (std::size_t i = 0; i < bits.size(); ++i)
    if (bits[i]) packed[i / 8] |= std::byte{1} << i % 8;
  return packed;
}

}  // namespace

TEST_CASE("PackedGroups_OnEveryInstructionSet_AreTheirDefinitionAndInverse") {
  fused_rows::on_every_target([](const char* target) {
    std::mt19937 generator(3);
    const auto random = [&] { return static_cast<std::uint32_t>(generator()); };
    for (std::size_t groups : {0u, 1u, 2u, 3u, 7u, 33u, 200u}) {
      for (int turn = 0; turn < 20; ++turn) {
        CAPTURE(target, groups, turn);
        std::vector<std::uint32_t> words(groups * kGroupWords), expected_widths(groups);
        for (std::size_t group = 0; group < groups; ++group) {
          // Each width in turn, then any; the largest word is at any place.
          const std::uint32_t width =
              turn == 0 ? static_cast<std::uint32_t>(group % 33) : random() % 33;
          expected_widths[group] = width;
          for (std::size_t i = 0; i < kGroupWords && width > 0; ++i)
            words[group * kGroupWords + i] = random() >> (32 - width);
          if (width > 0) words[group * kGroupWords + random() % kGroupWords] |= 1u << (width - 1);
        }
        const auto* const bytes = reinterpret_cast<const std::byte*>(words.data());
        std::vector<std::uint32_t> widths(groups);
        find_widths(bytes, groups, widths.data());
        REQUIRE(widths == expected_widths);
        const std::vector<std::byte> expected = packed_by_definition(words, widths);
        // Of exactly its size, so that the address sanitizer sees one byte too far.
        const auto packed = std::make_unique<std::byte[]>(expected.size());
        pack_groups(bytes, groups, widths.data(), packed.get());
        REQUIRE(std::equal(expected.begin(), expected.end(), packed.get()));
        std::vector<std::uint32_t> back(words.size(), 0xcccccccc);
        unpack_groups(packed.get(), expected.size(), widths.data(), groups,
                      reinterpret_cast<std::byte*>(back.data()));
        REQUIRE(back == words);
      }
    }
  });
}

}  // namespace plait::test
