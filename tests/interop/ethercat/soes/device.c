/* A device with SOES: hardware layer and application. The slave controller is in Python.
 *
 * SOES calls ESC_read and ESC_write, which call the functions that soes_start was given. The object
 * list is that of the demo for the LAN9252, as it is in the source of SOES.
 */
#include <string.h>
#include "ecat_slv.h"
#include "esc_eoe.h"
#include "esc_foe.h"
#include "utypes.h"

#define FILE_SIZE 4096
#define FRAME_SIZE 1536
#define MAC_SIZE 6

typedef void (*esc_access_t) (uint16_t address, uint8_t * data, uint16_t length);

static esc_access_t esc_reader, esc_writer;

_Objects Obj;
uint8_t soes_file[FILE_SIZE];
uint32_t soes_file_size;

/* hardware layer */

static void look_for_events (void)
{
   uint32_t event;
   esc_reader (ESCREG_ALEVENT, (uint8_t *) &event, sizeof event);
   ESCvar.ALevent = (uint16_t) etohl (event);
}

void ESC_read (uint16_t address, void * buf, uint16_t len)
{
   esc_reader (address, buf, len);
   look_for_events ();
}

void ESC_write (uint16_t address, void * buf, uint16_t len)
{
   esc_writer (address, buf, len);
   look_for_events ();
}

void ESC_init (const esc_cfg_t * cfg) { (void) cfg; }
void ESC_reset (void) {}
void ESC_interrupt_enable (uint32_t mask) { (void) mask; }
void ESC_interrupt_disable (uint32_t mask) { (void) mask; }

/* process data: the button counts the outputs */

void cb_get_inputs (void)
{
   Obj.Buttons.Button1 = (uint8_t) (Obj.LEDs.LED0 + Obj.LEDs.LED1 * Obj.Parameters.Multiplier);
}

void cb_set_outputs (void) {}

/* a file in memory */

static uint32_t write_file (foe_file_cfg_t * self, uint8_t * data, size_t length)
{
   if (self->address_offset + length > FILE_SIZE)
   {
      return 1;
   }
   memcpy (soes_file + self->address_offset, data, length);
   soes_file_size = self->address_offset + (uint32_t) length;
   return 0;
}

static uint8_t file_buffer[128];
static foe_file_cfg_t files[] = {
   {.name = "firmware.bin", .max_data = FILE_SIZE, .filepass = 0xBEEF,
    .write_function = write_file},
};
static foe_cfg_t foe = {
   .fbuffer = file_buffer, .buffer_size = sizeof file_buffer, .n_files = 1, .files = files};

/* a network port that sends each frame back to where it came from */

static uint8_t received[FRAME_SIZE], sent[FRAME_SIZE];
static size_t waiting;

static void get_buffer (eoe_pbuf_t * ebuf)
{
   ebuf->pbuf = ebuf->payload = received;
   ebuf->len = sizeof received;
}

static void free_buffer (eoe_pbuf_t * ebuf) { (void) ebuf; }
static int accept_settings (void) { return 0; }

static void handle_frame (uint8_t port, eoe_pbuf_t * ebuf)
{
   (void) port;
   memcpy (sent, ebuf->payload, ebuf->len);
   memcpy (sent, ebuf->payload + MAC_SIZE, MAC_SIZE);
   memcpy (sent + MAC_SIZE, ebuf->payload, MAC_SIZE);
   waiting = ebuf->len;
}

static int fetch_frame (uint8_t port, eoe_pbuf_t * ebuf)
{
   (void) port;
   if (waiting == 0)
   {
      return -1;
   }
   ebuf->pbuf = ebuf->payload = sent;
   ebuf->len = waiting;
   waiting = 0;
   return (int) ebuf->len;
}

static eoe_cfg_t eoe = {
   .get_buffer = get_buffer,
   .free_buffer = free_buffer,
   .load_eth_settings = accept_settings,
   .store_ethernet_settings = accept_settings,
   .handle_recv_buffer = handle_frame,
   .fetch_send_buffer = fetch_frame,
};

/* start and poll */

void soes_start (esc_access_t reader, esc_access_t writer, int polls_without_outputs)
{
   static esc_cfg_t config;
   esc_reader = reader;
   esc_writer = writer;
   config.watchdog_cnt = polls_without_outputs;
   memset (&Obj, 0, sizeof Obj);
   FOE_config (&foe);
   EOE_config (&eoe);
   ecat_slv_init (&config);
}

void soes_poll (void) { ecat_slv (); }
