// The fields of a dataset's description, each described once. Messages, the metadata of prepared
// files, JSON, Python and the description of the HTTP interface are made from this table: a new
// field is a member of DatasetInfo, a line here, and a field of the same name in
// proto/multitetra/v1/dataset.proto. A type that no field has yet needs its forms there.
#pragma once

#include <string_view>

#include "common/dataset/dataset_info.hpp"

// FIELD(name, member, what it says; null stands for no value). Without content_id, which only
// messages have, and label_extent, which they have in the label.
// clang-format off
#define MULTITETRA_DATASET_FIELDS(FIELD) \
  FIELD(name, name, "")                                                                           \
  FIELD(dims, dims, "Samples along x, y, z.")                                                     \
  FIELD(type, type, "The type of the stored samples.")                                            \
  FIELD(spacing, spacing, "World units between samples.")                                         \
  FIELD(min, min, "The least sample that is not void.")                                           \
  FIELD(max, max, "The greatest sample that is not void.")                                        \
  FIELD(void_samples, void_samples, "The number of samples without a value.")                     \
  FIELD(outside, outside, "The value beyond the data; null: void.")                               \
  FIELD(margin, margin, "Grid steps from the grid's origin to the first sample.")                 \
  FIELD(grid_exponent, grid_exponent, "The grid has 2^grid_exponent steps per side.")             \
  FIELD(index_to_world, index_to_world,                                                           \
        "The steps in world coordinates along x, y and z, and the position of the first "         \
        "sample.")                                                                                \
  FIELD(space, meaning.space,                                                                     \
        "Axes of world coordinates: x, y, z to the patient's left, back and head (LPS), or "      \
        "right, front and head (RAS); null: those of the file.")                                  \
  FIELD(length_unit, meaning.length_unit,                                                         \
        "Unit of spacing and world coordinates, such as mm; null: unknown.")                      \
  FIELD(value_unit, meaning.value_unit,                                                           \
        "Unit of samples and isovalues, such as HU; null: unknown.")                              \
  FIELD(geometry, meaning.geometry,                                                               \
        "How much of spacing and origin the source states; null: unknown.")                       \
  FIELD(assumed, meaning.assumed,                                                                 \
        "What of them is assumed, such as \"spacing along z\"; null: nothing.")                   \
  FIELD(rounding, meaning.rounding,                                                               \
        "Rounding of samples to 32-bit floats by more than a ten-thousandth of their range, "     \
        "such as \"up to 0.06, 0.5 % of their range\"; null: less, or unknown.")                  \
  FIELD(suggested_isovalues, suggested_isovalues, "Suggested isovalues, the best first.")         \
  FIELD(display_window, display_window,                                                           \
        "The values that the source recommends for the darkest and the brightest color, such "    \
        "as start and end of an OMERO window; null: none.")                                       \
  FIELD(member, member,                                                                           \
        "Place of the dataset in its series: datasets on the same grid, such as the times of "    \
        "a scan, the fields of a simulation, the labels of a segmentation; null: not in a "       \
        "series.")                                                                                \
  FIELD(missing, missing,                                                                         \
        "\"errors\" while the errors of the samples are not computed: surfaces are certified, "   \
        "estimates are crude; null: nothing is missing.")                                         \
  FIELD(histogram, histogram, "Absent in lists.")
// clang-format on

namespace multitetra {

struct DatasetField {
  const char* name;
  std::string_view help;
};

// Calls visit(field, member) for each, in the order of the documents. `info` may be constant.
template <typename Info, typename Visit>
void visit_dataset_fields(Info& info, const Visit& visit) {
#define MULTITETRA_VISIT(key, member, help) visit(DatasetField{#key, help}, info.member);
  MULTITETRA_DATASET_FIELDS(MULTITETRA_VISIT)
#undef MULTITETRA_VISIT
}

}  // namespace multitetra
