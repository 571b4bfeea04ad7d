/* Options of SOES for the device of tests/interop/ethercat/soes: all that it has. */
#ifndef __ECAT_OPTIONS_H__
#define __ECAT_OPTIONS_H__

#include "cc.h"

#define USE_FOE 1
#define USE_EOE 1

#define MBXSIZE 128
#define MBXSIZEBOOT 128
#define MBXBUFFERS 3

#define SM2_sma 0x1100
#define SM3_sma 0x1180
#define MAX_RXPDO_SIZE 42
#define MAX_TXPDO_SIZE 42
#define MAX_MAPPINGS_SM2 2
#define MAX_MAPPINGS_SM3 1

#endif
