#include <catch2/catch.hpp>

#include "backends/conformance.h"
#include "compressed/filters/built_in_filters.h"

namespace plait::test {

TEST_CASE("ShuffleFilter_AnyWidthAndSize_IsTheDefinitionAndItsInverse") {
  for (const std::size_t width : {2u, 4u, 8u}) {
    const auto filter = make_shuffle_filter(width);
    for (const std::size_t size :
         {0u, 1u, 2u, 7u, 8u, 9u, 63u, 64u, 65u, 127u, 128u, 1000u, 4096u, 70000u}) {
      INFO(width << ' ' << size);
      const auto raw = make_content(size, Content::kRandom, 1);
      std::vector<std::byte> filtered(size), back(size);
      filter->encode({}, raw, filtered);
      const std::size_t count = size / width;
      std::size_t wrong = 0;
      for (std::size_t at = 0; at < size; ++at) {
        const std::size_t place = at < count * width ? at % width * count + at / width : at;
        if (filtered[place] != raw[at]) ++wrong;
      }
      CHECK(wrong == 0);
      filter->decode({}, filtered, back);
      CHECK(back == raw);
    }
  }
}

}  // namespace plait::test
