// Draws the plots of a page as SVG in HTML.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "base/text.h"
#include "instrument/figure_text.h"
#include "instrument/page.h"

namespace plait::instrument {
namespace {

constexpr double kWidth = 900, kLetter = 7.4;
constexpr const char* kLogarithmic = " (log scale)";

/// A number as a person reads it; page.h lists the units.
std::string readable(double value, const std::string& unit) {
  if (!std::isfinite(value)) return "–";
  if (unit == "s" && value > 0) return seconds_text(value);
  if (unit == "B" && value >= 0 && value < 1e18)
    return format_bytes(static_cast<std::uint64_t>(std::llround(value)));
  return fmt::format("{:.3g} {}", value, unit);
}

/// About eight round numbers from low to high: multiples of 1, 2 or 5 times a power of ten.
std::vector<double> round_numbers(double low, double high) {
  const double rough = (high - low) / 8;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double factor : {5, 2, 1})
    if (factor * power >= 0.999 * rough) step = factor * power;
  std::vector<double> numbers;
  for (double at = std::ceil(low / step - 1e-9); at * step <= high + 1e-9 * step; ++at)
    numbers.push_back(at * step);
  return numbers;
}

/// From values to places on the drawing, by their logarithms.
class AxisScale {
 public:
  AxisScale(const Axis& axis, const std::vector<double>& values, double from, double to)
      : from_(from), to_(to) {
    double low = INFINITY, high = 0;
    for (const double value : values)
      if (shows(value)) {
        low = std::min(low, value);
        high = std::max(high, value);
      }
    if (low > high) low = high = 1;
    const double room = low == high ? 2 : 1.08;
    low_ = low / room;
    high_ = high * room;
    add_powers_of_ten();
    if (ticks.size() > 2) return;
    // Bytes are counted in powers of 1024.
    const double unit =
        axis.unit == "B" && high_ >= 1 ? std::pow(1024, std::floor(std::log2(high_) / 10)) : 1;
    ticks = round_numbers(low_ / unit, high_ / unit);
    for (double& tick : ticks) tick *= unit;
  }

  double at(double value) const {
    return from_ + std::log(value / low_) / std::log(high_ / low_) * (to_ - from_);
  }
  static bool shows(double value) { return std::isfinite(value) && value > 0; }

  std::vector<double> ticks;

 private:
  void add_powers_of_ten() {
    const double decades = std::log10(high_ / low_);
    const std::vector<int> factors = decades > 4     ? std::vector{1}
                                     : decades > 1.2 ? std::vector{1, 3}
                                                     : std::vector{1, 2, 5};
    const auto stride = std::max(1, static_cast<int>(decades / 8));
    for (int power = static_cast<int>(std::floor(std::log10(low_)));
         power <= std::ceil(std::log10(high_)); power += stride)
      for (const int factor : factors)
        if (const double tick = factor * std::pow(10, power); low_ <= tick && tick <= high_)
          ticks.push_back(tick);
  }

  double from_, to_, low_, high_;
};

/// Writes elements of a drawing.
class Drawing {
 public:
  Drawing(double height, const std::string& title, SeriesNames& series) : series_(series) {
    add("<svg class=\"drawing\" viewBox=\"0 0 {} {:.0f}\" role=\"img\" aria-label=\"{}\">\n",
        kWidth, height, escape_html(title));
  }
  std::string end() { return std::move(text_) + "</svg>"; }

  void line(const char* of, double x1, double y1, double x2, double y2,
            const std::string& more = "") {
    add("<line class=\"{}\" x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\"{}/>\n", of, x1,
        y1, x2, y2, more);
  }
  /// Cut where it has no room. `anchor` is start, middle or end.
  void label(const char* of, double x, double y, const std::string& text,
             const char* anchor = "start", double room = kWidth) {
    const auto most = static_cast<std::size_t>(std::max(3.0, room / kLetter));
    add("<text class=\"{}\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", of, x, y,
        anchor, escape_html(shortened(text, most)));
  }
  std::string colour_of(const std::string& name) {
    return fmt::format("var(--s{})", place_of(name) % 8);
  }
  /// Each series has a shape too, for those who do not see its colour.
  void mark(const std::string& name, double x, double y, bool hollow, const std::string& data,
            const std::string& title) {
    using Outline = std::vector<std::pair<double, double>>;
    static const Outline kOutlines[] = {{},
                                        {{-.85, -.85}, {.85, -.85}, {.85, .85}, {-.85, .85}},
                                        {{0, -1.2}, {1.2, 0}, {0, 1.2}, {-1.2, 0}},
                                        {{0, -1.15}, {1.1, .85}, {-1.1, .85}},
                                        {{-1.1, -.85}, {1.1, -.85}, {0, 1.15}}};
    constexpr double kSize = 4.6;
    std::string path;
    for (const auto& [dx, dy] : kOutlines[place_of(name) % std::size(kOutlines)])
      path +=
          fmt::format("{}{:.2f} {:.2f}", path.empty() ? "M" : "L", x + kSize * dx, y + kSize * dy);
    const std::string shape =
        path.empty() ? fmt::format("circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{}\"", x, y, kSize)
                     : fmt::format("path d=\"{}Z\"", path);
    add("<g class=\"mark{}\" style=\"{}:{}\" {} data-at=\"{:.2f}\"><title>{}</title><{}/></g>\n",
        hollow ? " hollow" : "", hollow ? "stroke" : "fill", colour_of(name), data, x,
        escape_html(title), shape);
  }
  /// Vertical grid lines with numbers below, and the axis' label under them.
  void x_axis(const Axis& axis, const AxisScale& scale, double top, double bottom, double from,
              double to) {
    double last = -INFINITY;
    for (const double tick : scale.ticks) {
      const double x = scale.at(tick);
      line("grid", x, top, x, bottom, fmt::format(" data-tick=\"{}\"", tick));
      if (x - last < 56) continue;
      last = x;
      label("tick", x, bottom + 15, readable(tick, axis.unit), "middle");
    }
    label("axis-label", (from + to) / 2, bottom + 33, axis.label + kLogarithmic, "middle");
  }

 private:
  template <class... Values>
  void add(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
  }
  std::size_t place_of(const std::string& name) {
    const auto found = std::ranges::find(series_, name);
    const auto place = static_cast<std::size_t>(found - series_.begin());
    if (found == series_.end()) series_.push_back(name);
    return place;
  }

  SeriesNames& series_;
  std::string text_;
};

std::string interval_text(double value, double low, double high, const std::string& unit) {
  std::string text = readable(value, unit);
  if (std::isfinite(low) && std::isfinite(high))
    text += fmt::format(" ({} to {})", readable(low, unit), readable(high, unit));
  return text;
}

}  // namespace

std::string svg_plot(const IntervalPlot& plot, SeriesNames& series) {
  constexpr double kRow = 24, kGroup = 22, kRight = kWidth - 16;
  std::vector<double> values;
  if (plot.reference) values.push_back(*plot.reference);
  std::size_t longest = 4;
  std::vector<std::string> groups;
  for (const IntervalPlot::Point& point : plot.points) {
    values.insert(values.end(), {point.value, point.low, point.high});
    longest = std::max(longest, point.name.size());
    if (std::ranges::find(groups, point.group) == groups.end()) groups.push_back(point.group);
  }
  const double left = std::min(static_cast<double>(longest) * kLetter + 14, kWidth * 0.4);
  double bottom = 8 + kRow * static_cast<double>(plot.points.size());
  for (const std::string& group : groups) bottom += 6 + (group.empty() ? 0 : kGroup);
  const AxisScale scale(plot.x, values, left, kRight);
  Drawing drawing(bottom + 42, plot.caption.title, series);
  drawing.x_axis(plot.x, scale, 4, bottom, left, kRight);
  if (plot.reference && AxisScale::shows(*plot.reference))
    drawing.line("reference", scale.at(*plot.reference), 4, scale.at(*plot.reference), bottom);
  double y = 8;
  for (const std::string& group : groups) {
    if (!group.empty()) drawing.label("group", 0, (y += kGroup) - 8, group);
    for (const IntervalPlot::Point& point : plot.points) {
      if (point.group != group) continue;
      const double middle = y + kRow / 2;
      y += kRow;
      drawing.label("name", left - 10, middle + 4, point.name, "end", left - 10);
      if (!AxisScale::shows(point.value)) continue;
      if (AxisScale::shows(point.low) && AxisScale::shows(point.high))
        drawing.line("interval", scale.at(point.low), middle, scale.at(point.high), middle,
                     fmt::format(" style=\"stroke:{}\"", drawing.colour_of(point.name)));
      drawing.mark(
          point.name, scale.at(point.value), middle, point.hollow,
          fmt::format("data-value=\"{}\"", point.value),
          fmt::format("{}{}{}: {}. {}", point.group, group.empty() ? "" : ", ", point.name,
                      interval_text(point.value, point.low, point.high, plot.x.unit), point.note));
    }
    y += 6;
  }
  return drawing.end();
}

std::string svg_plot(const ScatterPlot& plot, SeriesNames& series) {
  constexpr double kHeight = 400, kLeft = 86, kRight = kWidth - 18, kTop = 26,
                   kBottom = kHeight - 42;
  std::vector<double> xs, ys;
  for (const ScatterPlot::Point& point : plot.points) {
    xs.push_back(point.x);
    ys.insert(ys.end(), {point.y, point.y_low, point.y_high});
  }
  const AxisScale x(plot.x, xs, kLeft, kRight), y(plot.y, ys, kBottom, kTop);
  Drawing drawing(kHeight, plot.caption.title, series);
  for (const double tick : y.ticks) {
    drawing.line("grid", kLeft, y.at(tick), kRight, y.at(tick));
    drawing.label("tick", kLeft - 7, y.at(tick) + 4, readable(tick, plot.y.unit), "end");
  }
  drawing.x_axis(plot.x, x, kTop - 4, kBottom, kLeft, kRight);
  drawing.label("axis-label", 0, 11, plot.y.label + kLogarithmic);
  for (const ScatterPlot::Point& point : plot.points) {
    if (!AxisScale::shows(point.x) || !AxisScale::shows(point.y)) continue;
    const double px = x.at(point.x), py = y.at(point.y);
    if (AxisScale::shows(point.y_low) && AxisScale::shows(point.y_high))
      drawing.line("interval", px, y.at(point.y_low), px, y.at(point.y_high),
                   fmt::format(" style=\"stroke:{}\"", drawing.colour_of(point.series)));
    drawing.mark(
        point.series, px, py, !point.front,
        fmt::format("data-x=\"{}\" data-y=\"{}\"", point.x, point.y),
        fmt::format("{}. {}: {}. {}: {}", point.name, plot.x.label, readable(point.x, plot.x.unit),
                    plot.y.label, interval_text(point.y, point.y_low, point.y_high, plot.y.unit)));
    const bool is_right = px > (kLeft + kRight) / 2;
    if (point.front)
      drawing.label("name", px + (is_right ? -9 : 9), py - 8, point.name,
                    is_right ? "end" : "start");
  }
  return drawing.end();
}

}  // namespace plait::instrument
