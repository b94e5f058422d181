// SPDX-License-Identifier: Apache-2.0
#include "gps/component/gps_component.hpp"
#include "nacelle/node/component.hpp"

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::gps::GpsComponent>{
    .purpose =
        "Publishes the fix of a GPS receiver with its covariance, from the receiver's own estimate (GST) or from HDOP, "
        "and its "
        "velocity over ground and its time. Topics and parameters have the names of nmea_navsat_driver.",
    .devices =
        "GPS receivers that send NMEA 0183 (GGA, RMC; GSA, GST and VTG if they have them), on a serial line or by USB"};

NACELLE_REGISTER_COMPONENT(nacelle::gps::GpsComponent)
