#include "common/picture/canvas.hpp"

#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <pango/pangocairo.h>

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>

#include "common/base/utf8.hpp"
#include "common/image/png_file.hpp"

namespace multitetra {
namespace {

constexpr double kQuarterTurn = 1.57079632679489661923;

struct Free {
  void operator()(cairo_t* context) const { cairo_destroy(context); }
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
  void operator()(PangoLayout* layout) const { g_object_unref(layout); }
  void operator()(PangoFontDescription* font) const { pango_font_description_free(font); }
};
using SurfacePtr = std::unique_ptr<cairo_surface_t, Free>;
using LayoutPtr = std::unique_ptr<PangoLayout, Free>;

void set_color(cairo_t* context, Rgb color) {
  cairo_set_source_rgb(context, color[0] / 255.0, color[1] / 255.0, color[2] / 255.0);
}

void draw_path(cairo_t* context, std::span<const Canvas::Place> places) {
  cairo_new_path(context);
  for (const Canvas::Place& place : places) cairo_line_to(context, place.x, place.y);
}

LayoutPtr layout_of(cairo_t* context, std::string_view words, const Canvas::TextStyle& style) {
  LayoutPtr layout(pango_cairo_create_layout(context));
  const std::unique_ptr<PangoFontDescription, Free> font(pango_font_description_new());
  pango_font_description_set_family(font.get(), "sans-serif");
  pango_font_description_set_absolute_size(font.get(), style.size * PANGO_SCALE);
  if (style.is_bold) pango_font_description_set_weight(font.get(), PANGO_WEIGHT_BOLD);
  pango_layout_set_font_description(layout.get(), font.get());
  pango_layout_set_single_paragraph_mode(layout.get(), true);
  const std::string text = printable(words, /*keeps_lines=*/false);
  pango_layout_set_text(layout.get(), text.data(), static_cast<int>(text.size()));
  return layout;
}

double width_of(PangoLayout* layout) {
  int width = 0;
  int height = 0;
  pango_layout_get_size(layout, &width, &height);
  return static_cast<double>(width) / PANGO_SCALE;
}

// Puts a pixel with premultiplied colors, as Cairo has them, above another.
void put_above(Pixel& pixel, std::uint32_t argb) {
  const double share = (argb >> 24) / 255.0;
  if (share == 0) return;
  const double below = pixel[3] / 255.0 * (1 - share);
  const double opacity = share + below;
  for (std::size_t i = 0; i < 3; ++i) {
    const double above = (argb >> (16 - 8 * i)) & 0xFF;
    pixel[i] = static_cast<std::uint8_t>(std::lround((above + below * pixel[i]) / opacity));
  }
  pixel[3] = static_cast<std::uint8_t>(std::lround(255 * opacity));
}

cairo_status_t append(void* file, const unsigned char* bytes, unsigned int size) {
  static_cast<std::string*>(file)->append(reinterpret_cast<const char*>(bytes), size);
  return CAIRO_STATUS_SUCCESS;
}

}  // namespace

struct Canvas::Target {
  Target(SurfacePtr made, Picture* onto)
      : surface(std::move(made)), context(cairo_create(surface.get())), picture(onto) {
    cairo_set_line_cap(context.get(), CAIRO_LINE_CAP_ROUND);
    cairo_set_line_join(context.get(), CAIRO_LINE_JOIN_ROUND);
    if (cairo_status(context.get()) != CAIRO_STATUS_SUCCESS) {
      throw std::runtime_error(std::string("Cannot draw: ") +
                               cairo_status_to_string(cairo_status(context.get())) + ".");
    }
  }

  // Puts what was drawn above the picture, if there is one.
  void finish() const {
    if (!picture) return;
    cairo_surface_flush(surface.get());
    const unsigned char* row = cairo_image_surface_get_data(surface.get());
    auto pixel = picture->pixels.begin();
    for (int y = 0; y < picture->height; ++y) {
      const auto* drawn = reinterpret_cast<const std::uint32_t*>(row);
      for (int x = 0; x < picture->width; ++x) put_above(*pixel++, *drawn++);
      row += cairo_image_surface_get_stride(surface.get());
    }
  }

  SurfacePtr surface;
  std::unique_ptr<cairo_t, Free> context;
  Picture* picture;  // Null: the surface is a file.
};

Canvas::Canvas(std::unique_ptr<Target> target) : target_(std::move(target)) {}

Canvas::Canvas(Picture& picture, double scale)
    : target_(std::make_unique<Target>(SurfacePtr(cairo_image_surface_create(
                                           CAIRO_FORMAT_ARGB32, picture.width, picture.height)),
                                       &picture)) {
  cairo_scale(target_->context.get(), scale, scale);
}

Canvas::~Canvas() { target_->finish(); }

void Canvas::line(std::span<const Place> places, Rgb color, double width,
                  std::span<const double> dashes) {
  cairo_t* const context = target_->context.get();
  draw_path(context, places);
  set_color(context, color);
  cairo_set_line_width(context, width);
  cairo_set_dash(context, dashes.data(), static_cast<int>(dashes.size()), 0);
  cairo_stroke(context);
}

void Canvas::area(std::span<const Place> outline, Rgb color) {
  cairo_t* const context = target_->context.get();
  draw_path(context, outline);
  set_color(context, color);
  cairo_fill(context);
}

void Canvas::text(Place at, std::string_view words, const TextStyle& style) {
  cairo_t* const context = target_->context.get();
  const LayoutPtr layout = layout_of(context, words, style);
  const double width = width_of(layout.get());
  const double shift = style.anchor == Anchor::kStart    ? 0
                       : style.anchor == Anchor::kMiddle ? width / 2
                                                         : width;
  const double baseline =
      static_cast<double>(pango_layout_get_baseline(layout.get())) / PANGO_SCALE;
  cairo_save(context);
  cairo_translate(context, at.x, at.y);
  if (style.is_upwards) cairo_rotate(context, -kQuarterTurn);
  cairo_translate(context, -shift, -baseline);
  cairo_new_path(context);
  if (style.rim) {
    pango_cairo_layout_path(context, layout.get());
    set_color(context, *style.rim);
    cairo_set_line_width(context, style.size / 4);
    cairo_set_dash(context, nullptr, 0, 0);
    cairo_stroke(context);
  }
  cairo_move_to(context, 0, 0);
  set_color(context, style.color);
  pango_cairo_show_layout(context, layout.get());
  cairo_restore(context);
}

double Canvas::text_width(std::string_view words, const TextStyle& style) const {
  return width_of(layout_of(target_->context.get(), words, style).get());
}

std::string drawing(std::string_view suffix, int width, int height,
                    const std::function<void(Canvas&)>& draw) {
  if (suffix == ".png") {
    constexpr int kScale = 2;
    const std::size_t pixels = std::size_t{kScale * kScale} * static_cast<std::size_t>(width) *
                               static_cast<std::size_t>(height);
    Picture picture{.width = kScale * width,
                    .height = kScale * height,
                    .pixels = std::vector<Pixel>(pixels, Pixel{255, 255, 255, 255})};
    {
      Canvas canvas(picture, kScale);
      draw(canvas);
    }
    return png_file(picture);
  }
  std::string file;
  const auto create =
      suffix == ".pdf" ? cairo_pdf_surface_create_for_stream : cairo_svg_surface_create_for_stream;
  SurfacePtr surface(create(append, &file, width, height));
  cairo_surface_t* const page = surface.get();
  if (suffix == ".svg") cairo_svg_surface_set_document_unit(page, CAIRO_SVG_UNIT_PX);
  Canvas canvas(std::make_unique<Canvas::Target>(std::move(surface), nullptr));
  const auto right = static_cast<double>(width);
  const auto bottom = static_cast<double>(height);
  const Canvas::Place corners[] = {{0, 0}, {right, 0}, {right, bottom}, {0, bottom}};
  canvas.area(corners, {255, 255, 255});
  draw(canvas);
  cairo_surface_finish(page);
  if (cairo_surface_status(page) == CAIRO_STATUS_SUCCESS) return file;
  throw std::runtime_error(std::string("Cannot draw: ") +
                           cairo_status_to_string(cairo_surface_status(page)) + ".");
}

}  // namespace multitetra
