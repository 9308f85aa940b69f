// Pages as text: nothing hostile gets out of its place, and nothing refers to the network. What the
// browser makes of a page is tested by page_in_browser_test.sh.
#include "instrument/html_page.h"

#include <catch2/catch.hpp>
#include <regex>

#include "sample_page.h"

namespace plait::instrument {
namespace {

std::size_t count_of(const std::string& text, const std::string& word) {
  std::size_t count = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1))
    ++count;
  return count;
}

/// The JSON in the script element `id`, read as a browser reads it: up to the first "</script".
nlohmann::json data_of(const std::string& page, const std::string& id) {
  const std::string start = "<script type=\"application/json\" id=\"" + id + "\">";
  const std::size_t first = page.find(start) + start.size();
  return nlohmann::json::parse(page.substr(first, page.find("</script", first) - first));
}

TEST_CASE("text is escaped where it goes") {
  CHECK(escape_html("a<b>&\"'") == "a&lt;b&gt;&amp;&quot;&#39;");
  CHECK(escape_html("\xff\xfe") == "\xef\xbf\xbd\xef\xbf\xbd");
  CHECK(escape_html(std::string("a\0b\x1b[31m", 8)) == "a b [31m");
  CHECK(script_json("</script><!--&") == "\"\\u003c/script\\u003e\\u003c!--\\u0026\"");
  CHECK(nlohmann::json::parse(script_json(test::kHostileText)) == test::kHostileText);
}

TEST_CASE("hostile text stays text in every place of a page") {
  const std::string& hostile = test::kHostileText;
  HtmlPage page(hostile, hostile);
  page.verdict(hostile, Tone::kPlain);
  page.section(hostile);
  page.paragraph(hostile);
  page.list({hostile}, Tone::kDoubt);
  page.command(hostile);
  page.table({{hostile, hostile, hostile}, {{hostile}}, {{{hostile}}}});
  const Caption caption{hostile, hostile, hostile};
  const Axis axis{hostile, hostile};
  page.plot(IntervalPlot{caption, axis, 1,
                         std::vector<IntervalPlot::Point>(
                             kLeastPoints, {hostile, hostile, hostile, 1, 1, 1, hostile})});
  page.plot(ScatterPlot{
      caption, axis, axis,
      std::vector<ScatterPlot::Point>(kLeastPoints, {hostile, hostile, 1, 2, true, hostile})});
  page.embed("report", {{hostile, hostile}});
  const std::string text = page.html();
  CHECK(count_of(text, "<script") == 3);  // the page's own: data, plots, and the script
  CHECK(count_of(text, "</script") == 3);
  CHECK(count_of(text, "<img") == 0);
  CHECK(count_of(text, "<!--") == 0);
  CHECK(data_of(text, "plots").size() == 2);
  CHECK(data_of(text, "report") == nlohmann::json{{hostile, hostile}});
}

TEST_CASE("a page refers to nothing outside") {
  const std::string text = test::sample_page().html();
  std::string without_namespace = text;
  const std::string svg = "http://www.w3.org/2000/svg";  // a name, which is not loaded
  for (std::size_t at; (at = without_namespace.find(svg)) != std::string::npos;)
    without_namespace.erase(at, svg.size());
  CHECK(count_of(without_namespace, "://") == 0);
  CHECK(count_of(text, "@import") == 0);
  CHECK(count_of(text, "url(") == 0);
  CHECK(count_of(text, "fetch(") == 0);
  CHECK(count_of(text, "default-src 'none'") == 1);
}

TEST_CASE("the plots' data are the numbers that they were made of") {
  const nlohmann::json plots = data_of(test::sample_page().html(), "plots");
  REQUIRE(plots.size() == 2);
  CHECK(plots[0]["kind"] == "intervals");
  CHECK(plots[0]["points"].size() == 20);
  CHECK(plots[0]["points"][0]["value"] == 1.03);
  CHECK(plots[0]["x"]["scale"] == "log");
  CHECK(plots[1]["points"][1]["x_low"] == 17.8);
  CHECK(plots[1]["points"][0]["x_low"].is_null());
}

TEST_CASE("cells carry the exact number beside its text") {
  HtmlPage page("t", "");
  page.table({{}, {{"n"}}, {{{Cell("0.33", 1.0 / 3)}}, {{Cell("–", kMissing)}}}});
  const std::string text = page.html();
  CHECK(count_of(text, "data-value=\"0.3333333333333333\">0.33</td>") == 1);
  CHECK(count_of(text, "<td class=\"number\">–</td>") == 1);
}

TEST_CASE("a failure turns the page red, and nothing else does") {
  HtmlPage page("t", "");
  page.verdict("fine", Tone::kDoubt);
  CHECK(count_of(page.html(), "<body>") == 1);
  page.verdict("FAILED", Tone::kFailed);
  page.verdict("fine", Tone::kGood);
  CHECK(count_of(page.html(), "<body class=\"failed\">") == 1);
  CHECK(count_of(page.html(), "<title>FAILED: t</title>") == 1);
}

TEST_CASE("few points are a table with the same numbers") {
  HtmlPage page("t", "");
  page.plot(IntervalPlot{{"Latency"}, {}, {}, {{"", "pread", "", 0.25}, {"", "uring", "", 0.5}}});
  CHECK(data_of(page.html(), "plots").empty());
  CHECK(count_of(page.html(), "data-value=\"0.25\"") == 1);
  CHECK(count_of(page.html(), "<details>") == 0);
}

TEST_CASE("a plot without points says so") {
  HtmlPage page("t", "");
  page.plot(IntervalPlot{{"Latency"}, {}, {}, {}});
  CHECK(count_of(page.html(), "Latency: no run measured this.") == 1);
  CHECK(data_of(page.html(), "plots").empty());
}

}  // namespace
}  // namespace plait::instrument
