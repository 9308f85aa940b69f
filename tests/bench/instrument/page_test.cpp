// Pages: nothing hostile gets out of its place, nothing refers to the network, and plots are drawn
// to scale. What the browser makes of a page is tested by page_in_browser_test.sh.
#include "instrument/page.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <regex>
#include <string>
#include <vector>

#include "sample_page.h"

namespace plait::instrument {
namespace {

std::size_t count_of(const std::string& text, const std::string& word) {
  std::size_t count = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1))
    ++count;
  return count;
}

TEST_CASE("text is escaped where it goes") {
  CHECK(escape_html("a<b>&\"'") == "a&lt;b&gt;&amp;&quot;&#39;");
  CHECK(escape_html("\xff\xfe") == "\xef\xbf\xbd\xef\xbf\xbd");
  CHECK(escape_html(std::string("a\0b\x1b[31m", 8)) == "a b [31m");
}

TEST_CASE("hostile text stays text in every place of a page") {
  const std::string& hostile = test::kHostileText;
  Page page{hostile, hostile};
  page.add(Verdict{hostile, Tone::kPlain});
  page.add(Section{hostile});
  page.add(Paragraph{hostile});
  page.add(List{{hostile}, Tone::kDoubt});
  page.add(Command{hostile});
  page.add(Table{{hostile, hostile, hostile}, {{hostile}}, {{{hostile}}}});
  const Caption caption{hostile, hostile, hostile};
  const Axis axis{hostile, hostile};
  page.add(
      IntervalPlot{caption, axis, 1,
                   std::vector<IntervalPlot::Point>(20, {hostile, hostile, 1, 1, 1, hostile})});
  page.add(ScatterPlot{caption, axis, axis, {{hostile, hostile, 1, 2, true}}});
  const std::string text = to_html(page);
  CHECK(count_of(text, "<script") == 0);
  CHECK(count_of(text, "</script") == 0);
  CHECK(count_of(text, "<svg") == 2);
  CHECK(count_of(text, "<img") == 0);
  CHECK(count_of(text, "<!--") == 0);
}

TEST_CASE("a long name is cut between characters, not inside of one") {
  const auto name_in_plot = [](const std::string& name) {
    Page page{"t"};
    page.add(IntervalPlot{{}, {}, 1, std::vector<IntervalPlot::Point>(20, {"", name, 1})});
    const std::regex label("<text class=\"name\"[^>]*>([^<]*)</text>");
    const std::string text = to_html(page);
    std::smatch found;
    REQUIRE(std::regex_search(text, found, label));
    return found.str(1);
  };
  CHECK(name_in_plot("größer") == "größer");
  std::string many;
  for (int at = 0; at < 200; ++at) many += "ß";
  for (const std::string& name : {many, "a" + many, "ab" + many}) {
    const std::string shown = name_in_plot(name);
    CHECK(count_of(shown, "\xef\xbf\xbd") == 0);  // what stands for bytes that are no text
    CHECK(shown.ends_with("ß…"));
    CHECK(shown.size() < name.size());
  }
}

TEST_CASE("a page refers to nothing outside") {
  const std::string text = to_html(test::sample_page());
  CHECK(count_of(text, "://") == 0);
  CHECK(count_of(text, "@import") == 0);
  CHECK(count_of(text, "url(") == 0);
  CHECK(count_of(text, "fetch(") == 0);
  CHECK(count_of(text, "default-src 'none'") == 1);
}

/// The attribute `name` of each element that matches, as a number.
std::vector<double> numbers_of(const std::string& text, const std::string& name) {
  const std::regex attribute(name + "=\"([^\"]*)\"");
  std::vector<double> numbers;
  for (auto at = std::sregex_iterator(text.begin(), text.end(), attribute);
       at != std::sregex_iterator(); ++at)
    numbers.push_back(std::stod((*at)[1]));
  return numbers;
}

TEST_CASE("a mark is where the ticks beside it say that its value is") {
  const std::string text = to_html(test::sample_page());
  const auto drawing_after = [&](std::size_t from) {
    const std::size_t first = text.find("<svg", from);
    return text.substr(first, text.find("</svg>", first) - first);
  };
  const std::string intervals = drawing_after(0);
  const std::string scatter = drawing_after(text.find("</svg>"));
  const auto check = [](const std::string& drawing, const std::string& value) {
    std::vector<double> ticks, places;
    const std::regex line(
        "x1=\"([^\"]*)\" y1=\"[^\"]*\" x2=\"[^\"]*\" y2=\"[^\"]*\" data-tick=\"([^\"]*)\"");
    for (auto at = std::sregex_iterator(drawing.begin(), drawing.end(), line);
         at != std::sregex_iterator(); ++at) {
      places.push_back(std::stod((*at)[1]));
      ticks.push_back(std::stod((*at)[2]));
    }
    REQUIRE(ticks.size() >= 2);
    const std::vector<double> values = numbers_of(drawing, value),
                              at = numbers_of(drawing, "data-at");
    REQUIRE(values.size() == 20);
    REQUIRE(at.size() == 20);
    for (std::size_t i = 0; i < 20; ++i)
      CHECK(at[i] == Approx(places[0] + (std::log(values[i]) - std::log(ticks[0])) /
                                            (std::log(ticks.back()) - std::log(ticks[0])) *
                                            (places.back() - places[0]))
                         .margin(0.1));
  };
  check(intervals, "data-value");
  check(scatter, "data-x");
  // A name has one colour: five backends, of which one has outlines.
  CHECK(count_of(intervals, "var(--s0)") == 8);
  CHECK(count_of(intervals, "class=\"mark hollow\"") == 4);
}

TEST_CASE("tables are text and Markdown as well") {
  const Table table{{}, {{"", false}, {"ns a vertex"}}, {{{"a|b\x1b", "1.5"}}, {{"c", "-"}}}};
  CHECK(to_text(table) == "      ns a vertex\na|b?          1.5\nc               -\n");
  CHECK(to_markdown(table).starts_with("|  | ns a vertex |\n|---|---:|\n| a\\|b"));
  Page page{"t"};
  page.add(Section{"Heading"});
  page.add(table);
  page.add(Picture{"docs/images/p.png", "A picture"});
  CHECK(to_text(page).starts_with("t\n\nHeading\n-------\n"));
  CHECK(to_markdown(page, "docs").find("![A picture](images/p.png)") != std::string::npos);
}

TEST_CASE("a failure turns the page red, and nothing else does") {
  Page page{"t"};
  page.add(Verdict{"fine", Tone::kDoubt});
  CHECK(count_of(to_html(page), "<body>") == 1);
  page.add(Verdict{"FAILED", Tone::kFailed});
  page.add(Verdict{"fine", Tone::kGood});
  CHECK(count_of(to_html(page), "<body class=\"failed\">") == 1);
  CHECK(count_of(to_html(page), "<title>FAILED: t</title>") == 1);
}

TEST_CASE("a plot without points is left out") {
  Page page{"t"};
  page.add(IntervalPlot{{"Latency"}, {}, {}, {}});
  page.add(ScatterPlot{{"Latency"}, {}, {}, {}});
  CHECK(count_of(to_html(page), "<figure>") == 0);
}

}  // namespace
}  // namespace plait::instrument
