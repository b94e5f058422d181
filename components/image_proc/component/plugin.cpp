// SPDX-License-Identifier: Apache-2.0
#include "image_proc/component/compress_component.hpp"
#include "image_proc/component/debayer_component.hpp"
#include "image_proc/component/rectify_component.hpp"
#include "image_proc/component/resize_component.hpp"
#include "nacelle/node/component.hpp"

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::image_proc::CompressComponent>{
    .purpose =
        "Compresses images as JPEG while the compressed ones are read. They are published under the topic of the "
        "images "
        "with /compressed behind it, as compressed_image_transport does."};
template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::image_proc::DebayerComponent>{
    .purpose =
        "Makes images in colour and in grey of Bayer mosaics while they are read. Topics and parameters have the names "
        "of image_proc."};
template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::image_proc::RectifyComponent>{
    .purpose =
        "Takes the distortion of the lens out of images while the rectified ones are read. Topics and parameters have "
        "the names of image_proc."};
template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::image_proc::ResizeComponent>{
    .purpose =
        "Makes images smaller or larger, with the camera_info that belongs to them, while they are read. Topics and "
        "parameters have the names of image_proc."};

NACELLE_REGISTER_COMPONENT(nacelle::image_proc::CompressComponent, nacelle::image_proc::DebayerComponent,
                           nacelle::image_proc::RectifyComponent, nacelle::image_proc::ResizeComponent)
