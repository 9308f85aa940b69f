// bench/instrument/html_page.h: a page of measurements in one HTML file: text, tables that sort,
// and plots. The file refers to nothing outside: its style and script are ours (instrument/page),
// and its policy forbids the browser to load anything. It follows the reader's light or dark
// setting, prints, and works by keyboard. Without a script, the tables under the plots show the
// same numbers.
//
// Every text may be hostile (names from a foreign file): it is escaped where it goes. Text that is
// not UTF-8 gets replacement characters; numbers that are not finite are shown as missing.
//
// For one thread. Nothing here throws but for lack of memory.
#pragma once

#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace plait::instrument {

/// A number that is not known.
constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

enum class Tone : std::uint8_t {
  kPlain,
  kGood,
  kDoubt,   ///< amber: what limits the trust in the page
  kFailed,  ///< red; as the tone of the verdict it turns the whole page red
};

enum class Scale : std::uint8_t {
  kLinear,
  kLog,
};

struct Axis {
  std::string label;
  /// How numbers are written: "s", "B" (powers of 1024), "B/s" (powers of 1000), "x" (a factor),
  /// "%" (of 1), or any other text, which follows the number.
  std::string unit = {};
  Scale scale = Scale::kLinear;
  bool from_zero = false;  ///< linear only: the axis begins at 0
};

/// The text around a plot or a table.
struct Caption {
  std::string title;
  std::string how_to_read = {};  ///< one line
  std::string command = {};      ///< reproduces the numbers; empty: none is shown
};

/// A cell of a table: what is shown, and the number that it sorts by.
struct Cell {
  Cell(std::string shown) : text(std::move(shown)) {}  // NOLINT: cells are written as their text
  Cell(const char* shown) : text(shown) {}             // NOLINT
  Cell(std::string shown, double number) : text(std::move(shown)), value(number) {}

  std::string text;
  std::optional<double> value = {};
};

struct Table {
  struct Column {
    std::string name;
    bool number = true;  ///< right-aligned
  };
  struct Row {
    std::vector<Cell> cells;
    Tone tone = Tone::kPlain;
  };
  Caption caption = {};
  std::vector<Column> columns = {};
  std::vector<Row> rows = {};
};

/// Dots with intervals, a row for each (group, name). Points of one row differ by their series.
struct IntervalPlot {
  struct Point {
    std::string group, name, series;  ///< group and series may be empty
    double value = kMissing, low = kMissing, high = kMissing;
    std::string note = {};  ///< shown with the numbers
    bool hollow = false;    ///< drawn as an outline: not to be relied on
  };
  Caption caption = {};
  Axis x = {};
  std::optional<double> reference = {};  ///< a dashed line at this value
  std::vector<Point> points = {};
};

/// Points with two coordinates. Those in front are filled, named and joined by a line.
struct ScatterPlot {
  struct Point {
    std::string series, name;
    double x = kMissing, y = kMissing;
    bool front = false;
    std::string note = {};
    double x_low = kMissing, x_high = kMissing, y_low = kMissing, y_high = kMissing;
  };
  Caption caption = {};
  Axis x = {}, y = {};
  std::vector<Point> points = {};
};

/// A plot of fewer points is a table, unless it is a ScatterPlot.
constexpr std::size_t kLeastPoints = 20;

class HtmlPage {
 public:
  HtmlPage(std::string title, std::string subtitle);

  /// One sentence in a box. kFailed turns the page red, and is put before the title in the tab.
  void verdict(const std::string& sentence, Tone tone);
  void section(const std::string& heading);
  void paragraph(const std::string& text);
  void list(const std::vector<std::string>& items, Tone tone);
  /// A command to paste, in a box.
  void command(const std::string& text);
  void table(const Table& table);
  /// A plot without anything to draw is left out, and a line says so; one of fewer points than a
  /// table shows at a glance is a table.
  void plot(const IntervalPlot& plot);
  void plot(const ScatterPlot& plot);
  /// Puts data into the page, for programs that read it: <script type="application/json" id="ID">.
  /// REQUIRES: `id` is made of letters, and is not "plots".
  void embed(const std::string& id, const nlohmann::ordered_json& data);

  /// All of the page.
  std::string html() const;

 private:
  void begin_figure(const Caption& caption);
  void add_plot(const Caption& caption, nlohmann::ordered_json plot, const Table& numbers);
  void write_rows(const Table& table);

  std::string title_, subtitle_;
  bool failed_ = false;
  std::string body_;
  nlohmann::ordered_json plots_ = nlohmann::ordered_json::array();
  std::string data_;
};

/// `text` for HTML: the characters & < > " ' become entities. Pinned by html_page_test.cpp.
std::string escape_html(std::string_view text);

/// `data` for a <script>: no text in it can end the script.
std::string script_json(const nlohmann::ordered_json& data);

}  // namespace plait::instrument
